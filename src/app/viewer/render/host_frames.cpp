// SPDX-License-Identifier: MIT
#include "app/viewer/render/host_frames.h"

#include "app/inspect/heatmap_frame.h"
#include "app/picture/palette.h"
#include "app/viewer/render/all_modes.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/samples.h"
#include "io/camera/lens_views.h"

namespace qs {
namespace {

RenderedFrame draw_values(RenderContext& context, const FrameRequest& request,
                          const Camera& camera) {
  Outputs outputs = outputs_for(request.quantity);
  outputs.color = false;
  const Frame& frame = context.session.renderer->render(
      camera, request.settings, with_counts(outputs, request), HostImage{}, context.stop);
  ValueMap map = map_of(frame, request.quantity, camera.width, camera.height);
  RenderedFrame rendered{shown_of(request, frame), camera.width, camera.height,
                         to_rgba(colored(map))};
  rendered.shown.values = std::move(map);
  return rendered;
}

// No effect until the user has requested the reference of this view and it is computed.
void set_beside_reference(const RenderContext& context, const FrameRequest& request,
                          RenderedFrame& rendered) {
  const std::optional<ReferenceImage>& reference = context.reference;
  if (!reference || reference->view_version != request.view_version || request.divisor > 1) return;
  const PixelBox& box = reference->region;
  rendered.other = rendered.rgba;
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x)
      for (int c = 0; c < 3; ++c)
        rendered.other[static_cast<std::size_t>(4 * (y * rendered.width + x) + c)] =
            to_8bit(reference->image.at(x, y, c));
  }
  ShownOther& other = rendered.shown.other.emplace();
  other.variant = *request.other;
  other.region = box;
}

// A frame with the heat map of the request if it has one.
struct MappedFrame {
  const Frame& frame;
  std::optional<FrameHeatmap> map;
};

// `pairs`: with the tile pairs, for a split window.
MappedFrame draw_mapped(RenderContext& context, Renderer& renderer, const FrameRequest& request,
                        const Camera& camera, bool pairs) {
  std::optional<HeatmapMaker> maker;
  if (request.heatmap)
    maker.emplace(renderer, camera, request.settings, *request.heatmap, *context.session.pool,
                  context.stop);
  Outputs outputs = with_counts(maker ? maker->outputs() : Outputs(), request);
  outputs.pairs |= pairs;
  // A trained model may have replaced the Gaussians since the request; a tree knows its selection.
  const Scene& scene = *context.session.scene;
  if (request.tint && (request.tint->size() == scene.cloud.size() || scene.stream))
    outputs.share = request.tint;
  const Frame& frame =
      renderer.render(camera, request.settings, outputs, HostImage{}, context.stop);
  return {frame, maker ? std::optional(maker->map(frame)) : std::nullopt};
}

// The frame of the scene in the window, with its map, in host memory.
struct FirstFrame {
  const Frame& frame;
  RenderedFrame rendered;
};

FirstFrame draw_first(RenderContext& context, const FrameRequest& request, const Camera& camera,
                      bool pairs) {
  const HeldScale scale = heat_scale(context, request, camera);
  MappedFrame drawn = draw_mapped(context, *context.session.renderer, request, camera, pairs);
  RenderedFrame rendered = rendered_of(context, request, drawn.frame);
  rendered.share = drawn.frame.share;
  if (drawn.map) {
    show_map(rendered.shown, std::move(drawn.map->heatmap), scale);
    rendered.shown.missed = std::move(drawn.map->missed);
  }
  return {drawn.frame, std::move(rendered)};
}

// Draws the other side of a split window. `pairs`: of the first side.
void draw_other(RenderContext& context, const FrameRequest& request, const Camera& camera,
                std::span<const std::uint32_t> pairs, RenderedFrame& rendered) {
  FrameRequest second = request;
  second.settings.mode = request.other->mode;
  second.settings.pipeline = request.other->pipeline;
  second.counted.reset();  // the first side has counted the view
  second.tint.reset();
  const bool beside = request.beside && context.beside;
  Renderer& renderer =
      beside ? renderer_beside(context) : renderer_on(context, request.other->backend);
  MappedFrame drawn = draw_mapped(context, renderer, second, camera, true);
  const Frame& frame = drawn.frame;
  rendered.other = to_rgba(frame.color, context.session.pool.get());
  ShownOther& other = rendered.shown.other.emplace();
  other.variant = *request.other;
  other.variant.pipeline = frame.stats.pipeline;  // that drew it
  if (beside) other.scene = context.beside->facts;
  other.stats = frame.stats;
  other.region = {0, 0, rendered.width, rendered.height};
  other.pairs = pair_difference(frame.grid, pairs, frame.pairs);
  other.pairs_scale = scale_for_signed(other.pairs->values);
  if (drawn.map) other.heatmap = std::move(drawn.map->heatmap);
}

RenderedFrame draw_beside(RenderContext& context, const FrameRequest& request,
                          const Camera& camera) {
  FirstFrame first = draw_first(context, request, camera, true);
  RenderedFrame rendered = std::move(first.rendered);
  if (request.other->mode == kReferenceMode) {
    set_beside_reference(context, request, rendered);
  } else {
    // The same renderer may draw the other frame, and it keeps only one frame.
    const std::vector<std::uint32_t> pairs = first.frame.pairs;
    draw_other(context, request, camera, pairs, rendered);
  }
  if (rendered.shown.other) {
    ShownOther& other = *rendered.shown.other;
    other.pixels = image_difference(rendered.rgba, rendered.other, rendered.width, other.region);
  }
  return rendered;
}

// Tints a picture by the share of selected Gaussians in each pixel, with stripes for eyes that do
// not see the colour. Pixels without a share stay as they are.
void tint(std::vector<std::uint8_t>& rgba, const std::vector<float>& share, int width,
          ThreadPool& pool) {
  constexpr float kStrong = 0.75f, kWeak = 0.55f;
  constexpr std::size_t kStripe = 4;  // pixels
  const auto columns = static_cast<std::size_t>(width);
  pool.for_each(share.size() / columns, 16, [&](std::size_t row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t at = row * columns + column;
      if (share[at] <= 0) continue;
      const float part = share[at] * ((row + column) / kStripe % 2 == 0 ? kStrong : kWeak);
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint8_t& value = rgba[4 * at + c];
        const float old = static_cast<float>(value) / 255;
        value = to_8bit(old + part * (kVermillion[static_cast<int>(c)] - old));
      }
    }
  });
}

RenderedFrame draw_any(RenderContext& context, const FrameRequest& request, const Camera& camera) {
  if (request.grid) return draw_grid(context, request, camera);
  if (request.other) return draw_beside(context, request, camera);
  if (request.quantity != Quantity::color) return draw_values(context, request, camera);
  return draw_first(context, request, camera, false).rendered;
}

}  // namespace

std::vector<std::uint8_t> to_rgba(const Image& image, ThreadPool* pool) {
  constexpr std::size_t kGrain = 1 << 15;  // pixels
  const std::size_t pixels = image.values.size() / 3;
  std::vector<std::uint8_t> rgba(4 * pixels, 255);
  const auto convert = [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t c = 0; c < 3; ++c) rgba[4 * i + c] = to_8bit(image.values[3 * i + c]);
  };
  pool != nullptr ? pool->for_chunks(pixels, kGrain, convert) : convert(0, pixels, 0);
  return rgba;
}

Image image_of(const std::vector<std::uint8_t>& rgba, int width, int height) {
  Image image(width, height, 3);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = static_cast<float>(rgba[i / 3 * 4 + i % 3]) / 255;
  return image;
}

RenderedFrame rendered_of(const RenderContext& context, const FrameRequest& request,
                          const Frame& frame) {
  return {shown_of(request, frame), frame.color.width, frame.color.height,
          to_rgba(frame.color, context.session.pool.get())};
}

Outputs with_counts(Outputs outputs, const FrameRequest& request) {
  outputs.mode_pairs = request.counted.has_value();
  outputs.counted = request.counted;
  return outputs;
}

ShownFrame shown_of(const FrameRequest& request, const Frame& frame) {
  ShownFrame shown;
  shown.stats = frame.stats;
  shown.mode_pairs = frame.mode_pairs;
  if (request.counted) shown.counted_size = size_of(request.counted->camera);
  shown.mode = request.settings.mode;
  shown.version = request.version;
  shown.view_version = request.view_version;
  shown.camera = request.camera;
  shown.divisor = request.divisor;
  return shown;
}

bool takes_one_frame(const FrameRequest& request) {
  return !has_faces(request.settings.lens) && !request.tint && !request.other && !request.grid &&
         request.quantity == Quantity::color &&
         (!request.heatmap || takes_one_frame(*request.heatmap));
}

RenderedFrame draw_on_host(RenderContext& context, const FrameRequest& request,
                           const Camera& camera) {
  RenderedFrame rendered = draw_any(context, request, camera);
  const std::vector<float> share = std::move(rendered.share);
  if (share.empty()) return rendered;
  tint(rendered.rgba, share, rendered.width, *context.session.pool);
  if (!rendered.other.empty() && !request.beside)
    tint(rendered.other, share, rendered.width, *context.session.pool);
  return rendered;
}

HeldScale heat_scale(RenderContext& context, const FrameRequest& request, const Camera& camera) {
  if (!request.heatmap) return {};
  const HeatQuantity quantity = *request.heatmap;
  if (request.heat_maximum > 0)
    return {quantity, request.baseline, request.view_version, exact_scale(request.heat_maximum)};
  const bool final = !request.moving && request.divisor == 1;
  std::optional<HeldScale>& held = context.heat_scale;
  const bool same_kind = held && held->quantity == quantity && held->baseline == request.baseline;
  if (same_kind && (!final || held->view_version == request.view_version)) return *held;
  RenderSettings settings = request.settings;
  settings.mode = request.baseline;
  const Scale scale = scale_of_view(*context.session.renderer, camera, settings, quantity,
                                    *context.session.pool, context.stop);
  held = {quantity, request.baseline, final ? request.view_version : -1, scale};
  return *held;
}

void show_map(ShownFrame& shown, Heatmap map, const HeldScale& scale) {
  shown.heatmap = std::move(map);
  shown.map_scale = scale.scale;
  shown.scale_version = scale.view_version;
}

}  // namespace qs
