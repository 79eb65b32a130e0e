// SPDX-License-Identifier: MIT
#include "app/viewer/render/host_frames.h"

#include "app/inspect/heatmap_frame.h"

namespace qs {
namespace {

std::vector<std::uint8_t> to_rgba(const Image& image) {
  const std::size_t pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  std::vector<std::uint8_t> rgba(4 * pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) rgba[4 * i + c] = to_8bit(image.values[3 * i + c]);
    rgba[4 * i + 3] = 255;
  }
  return rgba;
}

FrameReply reply_of(const FrameOrder& order, const Frame& frame) {
  return {shown_of(order, frame.stats),
          frame.color.width,
          frame.color.height,
          to_rgba(frame.color),
          {},
          {}};
}

FrameReply draw_with_map(RenderContext& context, const FrameOrder& order, const Camera& camera) {
  HeatmapFrame mapped = render_with_heatmap(*context.session.renderer, camera, order.settings,
                                            *order.heatmap, context.options.threads, context.stop);
  FrameReply reply = reply_of(order, mapped.frame);
  reply.shown.heatmap = std::move(mapped.heatmap);
  reply.shown.missed = std::move(mapped.missed);
  return reply;
}

// Nothing when the reference of this view was not computed yet: that takes seconds, and a key.
void set_beside_reference(const RenderContext& context, const FrameOrder& order,
                          FrameReply& reply) {
  const std::optional<ReferenceImage>& reference = context.reference;
  if (!reference || reference->view_version != order.view_version || order.divisor > 1) return;
  const PixelBox& box = reference->region;
  reply.other = reply.rgba;
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      for (int c = 0; c < 3; ++c)
        reply.other[static_cast<std::size_t>(4 * (y * reply.width + x) + c)] =
            to_8bit(reference->image.at(x, y, c));
    }
  }
  reply.shown.other = ShownOther{*order.other, {}, box, {}, std::nullopt};
}

FrameReply draw_beside(RenderContext& context, const FrameOrder& order, const Camera& camera) {
  Outputs outputs;
  outputs.pairs = true;
  const Frame& frame =
      context.session.renderer->render(camera, order.settings, outputs, HostImage{}, context.stop);
  FrameReply reply = reply_of(order, frame);
  if (order.other->mode == kReferenceMode) {
    set_beside_reference(context, order, reply);
  } else {
    // The other one may be drawn by the same renderer, which keeps one frame.
    const TileGrid grid = frame.grid;
    const std::vector<std::uint32_t> pairs = frame.pairs;
    RenderSettings settings = order.settings;
    settings.mode = order.other->mode;
    settings.pipeline = order.other->pipeline;
    const Frame& other = renderer_on(context, order.other->backend)
                             .render(camera, settings, outputs, HostImage{}, context.stop);
    reply.other = to_rgba(other.color);
    reply.shown.other = ShownOther{*order.other,
                                   other.stats,
                                   {0, 0, reply.width, reply.height},
                                   {},
                                   pair_difference(grid, pairs, other.pairs)};
  }
  if (reply.shown.other) {
    ShownOther& other = *reply.shown.other;
    other.pixels = image_difference(reply.rgba, reply.other, reply.width, other.region);
  }
  return reply;
}

}  // namespace

ShownFrame shown_of(const FrameOrder& order, const RenderStats& stats) {
  ShownFrame shown;
  shown.stats = stats;
  shown.mode = order.settings.mode;
  shown.version = order.version;
  shown.camera = order.camera;
  shown.divisor = order.divisor;
  return shown;
}

bool takes_one_frame(const FrameOrder& order) {
  return !order.other && order.heatmap != HeatQuantity::missed;
}

FrameReply draw_on_host(RenderContext& context, const FrameOrder& order, const Camera& camera) {
  if (order.other) return draw_beside(context, order, camera);
  if (order.heatmap) return draw_with_map(context, order, camera);
  return reply_of(order, context.session.renderer->render(camera, order.settings, {}, HostImage{},
                                                          context.stop));
}

}  // namespace qs
