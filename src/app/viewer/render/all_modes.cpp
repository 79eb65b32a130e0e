// SPDX-License-Identifier: MIT
#include "app/viewer/render/all_modes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "app/inspect/heatmap_frame.h"
#include "app/measure/measure_view.h"
#include "app/picture/canvas.h"
#include "app/picture/grid_places.h"
#include "app/picture/palette.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/resolution.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/samples.h"
#include "base/seconds.h"
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

ViewPlan warm_up_plan(Backend backend) { return {backend == Backend::cpu ? 1 : 8, 0, 1, false}; }

// Draws a frame that nobody sees.
RenderStats stats_of(RenderContext& context, const Camera& camera, RenderSettings settings,
                     CullMode mode) {
  settings.mode = mode;
  const Target target =
      context.session.backend == Backend::cpu ? Target(HostImage{}) : Target(DeviceImage{});
  return context.session.renderer->render(camera, settings, {}, target, context.stop).stats;
}

// The time by which two frames compare. Other programs interrupt frames of a busy processor for
// longer than frames take, so the CPU's frames compare by the time that they use.
double used_ms(const RenderStats& stats) {
  return static_cast<double>(stats.cpu_ms > 0 ? stats.cpu_ms : stats.frame_ms);
}

// Draws a frame of another mode than a picture's, which used `shown_ms`, and reports the pair.
void draw_pair(RenderContext& context, const Camera& camera, const RenderSettings& settings,
               CullMode mode, double shown_ms, int view_version) {
  const double ms = used_ms(stats_of(context, camera, settings, mode));
  if (ms <= 0 || shown_ms <= 0) return;
  const Variant variant{mode, settings.pipeline, context.session.backend};
  context.report(action::frame_paired,
                 PairedFrame{variant, settings.mode, shown_ms / ms, size_of(camera), view_version});
}

// Draws each mode once before a measurement, which warms it up, and shows the times until enough
// frames are measured.
void pair_all(RenderContext& context, const NumbersRequest& request) {
  const auto& [camera, settings, version, more] = request;
  const double ms = used_ms(stats_of(context, camera, settings, settings.mode));
  for (CullMode mode = 1; mode <= culler_count(); ++mode)
    if (mode != settings.mode) draw_pair(context, camera, settings, mode, ms, version);
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

CullMode PairedFrames::next_in_turn() {
  do {
    last_ = last_ % culler_count() + 1;
  } while (last_ == shown_);
  return last_;
}

void PairedFrames::follow(RenderContext& context, const FrameRequest& request, const Camera& camera,
                          const RenderStats& shown) {
  constexpr double kMostPauseMs = 500;  // a longer one gives no more credit
  const CullMode before = std::exchange(shown_, request.settings.mode);
  if (!request.pairs) return;
  const bool switched = before > 0 && before != shown_;
  const auto began = std::chrono::steady_clock::now();
  const double passed =
      std::min(milliseconds_since(std::exchange(now_, began).value_or(began)), kMostPauseMs);
  credit_ += passed * (context.session.backend == Backend::cpu ? 0.18 : 0.05);
  if (cost_ == 0) cost_ = static_cast<double>(shown.frame_ms);
  if (credit_ < cost_ && !switched) return;
  const CullMode mode = switched ? before : next_in_turn();
  draw_pair(context, camera, reduced(request.settings, request.divisor), mode, used_ms(shown),
            request.view_version);
  cost_ = milliseconds_since(began);
  credit_ = std::min(credit_ - cost_, cost_);
}

void measure_modes(RenderContext& context, const NumbersRequest& request) {
  const auto measuring = mark_measuring(context);
  Session& session = context.session;
  const auto settings = with_settings(session, request.settings);
  ModeNumbers numbers{request.version, {}};
  // Rounds of one frame per mode, so that every frame has a frame of the other modes beside it.
  // Enough for a stable median, few enough not to be noticeable.
  const int rounds = session.backend != Backend::cpu ? 40
                     : request.more                  ? 10
                                                     : static_cast<int>(kFewestFrames);
  try {
    if (!request.more) pair_all(context, request);
    for (const Pipeline pipeline : pipelines_of(session.backend)) {
      session.settings.pipeline = pipeline;
      const auto measured_with = [&](const ViewPlan& plan) {
        return measure_view(session, all_modes(), request.camera, plan, {{}, context.stop});
      };
      const bool sampled = !request.more && pipeline == request.settings.pipeline;
      if (session.backend != Backend::cpu || !sampled) measured_with(warm_up_plan(session.backend));
      const auto measured = measured_with({1, 0, rounds, !request.more});
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
