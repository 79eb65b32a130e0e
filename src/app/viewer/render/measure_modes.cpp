// SPDX-License-Identifier: MIT
#include "app/viewer/render/measure_modes.h"

#include "app/measure/measure_view.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/samples.h"

namespace qs {
namespace {

// Rounds of one frame per mode, so that every frame has a frame of the other modes beside it.
// Enough for a stable median, few enough not to be noticeable.
ViewPlan numbers_plan(Backend backend, bool more) {
  const int rounds = backend != Backend::cpu ? 40 : more ? 10 : static_cast<int>(kFewestFrames);
  return {1, 0, rounds, !more};
}

ViewPlan warm_up_plan(Backend backend) { return {backend == Backend::cpu ? 1 : 8, 0, 1, false}; }

// Draws each mode once before a measurement, which warms it up, and shows the times until enough
// frames are measured.
void sample_all(RenderContext& context, const NumbersRequest& request) {
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    ModeSample about;
    about.variant.mode = mode;
    about.view_version = request.version;
    sample_mode(context, request.camera, request.settings, about);
  }
}

}  // namespace

void sample_mode(RenderContext& context, const Camera& camera, const RenderSettings& settings,
                 ModeSample about) {
  RenderSettings of_mode = settings;
  of_mode.mode = about.variant.mode;
  const Backend backend = context.session.backend;
  about.variant.pipeline = settings.pipeline;
  about.variant.backend = backend;
  const Target target = backend == Backend::cpu ? Target(HostImage{}) : Target(DeviceImage{});
  const Frame& frame = context.session.renderer->render(camera, of_mode, {}, target, context.stop);
  about.frame_ms = static_cast<double>(frame.stats.frame_ms);
  context.report(action::mode_sampled, about);
}

void measure_modes(RenderContext& context, const NumbersRequest& request) {
  const auto measuring = mark_measuring(context);
  Session& session = context.session;
  const auto settings = with_settings(session, request.settings);
  ModeNumbers numbers{request.version, {}};
  try {
    if (!request.more) sample_all(context, request);
    for (const Pipeline pipeline : pipelines_of(session.backend)) {
      session.settings.pipeline = pipeline;
      const auto measured_with = [&](const ViewPlan& plan) {
        return measure_view(session, all_modes(), request.camera, plan, {{}, context.stop});
      };
      const bool sampled = !request.more && pipeline == request.settings.pipeline;
      if (session.backend != Backend::cpu || !sampled) measured_with(warm_up_plan(session.backend));
      const auto measured = measured_with(numbers_plan(session.backend, request.more));
      numbers.rows.insert(numbers.rows.end(), measured.begin(), measured.end());
    }
  } catch (const Cancelled&) {
    throw;
  } catch (...) {
    context.report(action::numbers_measured, ModeNumbers{request.version, {}});
    throw;
  }
  context.report(request.more ? action::numbers_refined : action::numbers_measured,
                 std::move(numbers));
}

}  // namespace qs
