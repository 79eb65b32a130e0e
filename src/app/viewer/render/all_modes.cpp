// SPDX-License-Identifier: MIT
#include "app/viewer/render/all_modes.h"

#include <algorithm>
#include <cmath>

#include "app/inspect/heatmap_frame.h"
#include "app/measure/measure_view.h"
#include "app/picture/canvas.h"
#include "app/picture/grid_places.h"
#include "app/picture/palette.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/samples.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

ModePicture draw_mode(RenderContext& context, const FrameRequest& request, const Camera& camera,
                      const RenderSettings& settings, const Scale& scale) {
  Renderer& renderer = *context.session.renderer;
  ModePicture drawn;
  drawn.mode = settings.mode;
  if (!request.heatmap) {
    const Frame& frame = renderer.render(camera, settings, {}, HostImage{}, context.stop);
    drawn.image = frame.color;
    drawn.stats = frame.stats;
    return drawn;
  }
  HeatmapFrame mapped = render_with_heatmap(renderer, camera, settings, *request.heatmap,
                                            *context.session.pool, context.stop);
  drawn.image = draw_over(mapped.frame.color, mapped.heatmap, scale, request.heat_style);
  drawn.stats = mapped.frame.stats;
  drawn.heatmap = std::move(mapped.heatmap);
  return drawn;
}

int pixels_of(float share, int size) {
  return static_cast<int>(std::lround(share * static_cast<float>(size)));
}

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

void draw_all_modes(RenderContext& context, const FrameRequest& request, const Camera& camera,
                    const Scale& scale, const std::function<void(ModePicture)>& visit) {
  RenderSettings settings = request.settings;
  for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode)
    visit(draw_mode(context, request, camera, settings, scale));
}

RenderedFrame draw_grid(RenderContext& context, const FrameRequest& request, const Camera& camera) {
  const HeldScale scale = heat_scale(context, request, camera);
  const GridPlaces places = grid_places(culler_count(), kGridLabel);
  Image page(camera.width, camera.height, 3);
  fill_rect(page, {0, 0, page.width, page.height}, on_dark::kPanel);
  const int width = std::max(1, pixels_of(places.side, page.width));
  const int height = std::max(1, pixels_of(places.side, page.height));
  const CullMode current = std::clamp<CullMode>(request.settings.mode, 1, culler_count());
  RenderedFrame rendered;
  rendered.shown = shown_of(request, Frame());
  ShownGrid grid;
  draw_all_modes(context, request, camera, scale.scale, [&](ModePicture picture) {
    const glm::vec2 low = places.low(picture.mode - 1);
    paste(page, area_average(picture.image, width, height, *context.session.pool),
          {pixels_of(low.x, page.width), pixels_of(low.y, page.height)});
    grid.stats.push_back(picture.stats);
    if (picture.heatmap) grid.totals.push_back(picture.heatmap->total);
    if (picture.mode != current) return;
    rendered.shown.stats = picture.stats;
    if (picture.heatmap) show_map(rendered.shown, std::move(*picture.heatmap), scale);
  });
  rendered.width = page.width;
  rendered.height = page.height;
  rendered.rgba = to_rgba(page);
  rendered.shown.grid = std::move(grid);
  return rendered;
}

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
