// SPDX-License-Identifier: MIT
#include "app/viewer/render/frame_orders.h"

#include <algorithm>

#include "app/viewer/render/resolution.h"
#include "app/viewer/state/hud_text.h"

namespace qs {
namespace {

constexpr double kStillSeconds = 0.25;  ///< without motion before modes are measured

bool draws_on_the_cpu(const Viewer& viewer) {
  return viewer.backend == Backend::cpu ||
         (viewer.panels.split && viewer.split.other.backend == Backend::cpu);
}

bool is_still(const Viewer& viewer) {
  return viewer.now - viewer.last_motion > kStillSeconds && !viewer.playback.running;
}

}  // namespace

FrameOrder order_of(const Viewer& viewer) {
  FrameOrder order;
  order.camera = viewer.camera;
  order.settings = viewer.settings;
  order.settings.mode = viewer.mode();
  order.version = viewer.version;
  order.view_version = viewer.view_version;
  if (viewer.panels.split) {
    order.other = viewer.split.other;
  } else {
    order.heatmap = viewer.heatmap;
  }
  return order;
}

bool numbers_are_missing(const Viewer& viewer) {
  return viewer.shown.version == viewer.version && viewer.shown.divisor == 1 && viewer.on_demand &&
         viewer.panels.hud && viewer.panels.all && !numbers_are_current(viewer);
}

void FrameOrders::place(const Viewer& viewer, RenderThread& render, bool window_rests) {
  if (!viewer.scene || viewer.zoom.running) return;
  // Small while it moves, whole as soon as it rests.
  const int divisor =
      draws_on_the_cpu(viewer) && viewer.reduce_when_moving && viewer.moving()
          ? resolution_divisor(ms_per_megapixel_, viewer.camera.width, viewer.camera.height)
          : 1;
  const bool continuous = !viewer.on_demand && !render.busy();
  if (!are_placed(viewer) || divisor < divisor_ || continuous) {
    FrameOrder order = order_of(viewer);
    order.divisor = divisor;
    render.order(std::move(order));
    version_ = viewer.version;
    divisor_ = divisor;
  }
  if (is_still(viewer) && numbers_are_missing(viewer) && window_rests && !render.busy())
    render.order(NumbersOrder{viewer.camera, viewer.settings, viewer.view_version});
}

void FrameOrders::learn(const FrameReply& reply) {
  double ms = static_cast<double>(reply.shown.stats.frame_ms);
  if (reply.shown.other) ms += static_cast<double>(reply.shown.other->stats.frame_ms);
  const double megapixels = 1e-6 * reply.width * reply.height;
  ms_per_megapixel_ = ms / std::max(megapixels, 1e-3);
}

}  // namespace qs
