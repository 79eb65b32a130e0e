// SPDX-License-Identifier: MIT
#include "app/inspect/heatmap_frame.h"

#include <algorithm>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "app/inspect/inspection.h"
#include "app/inspect/pixel.h"
#include "app/picture/level_mapper.h"
#include "base/error.h"
#include "base/text.h"
#include "raster/kernel/composite.h"
#include "raster/lens/lens_view.h"

namespace qs {
namespace {

/// The state of a pixel while it is composited.
struct PixelState {
  float transmittance = 1;
  bool stopped = false;
  glm::vec3 color{0.0f};

  Step take(const Splat& splat, glm::vec2 at, float& alpha) {
    if (stopped) return Step::skips;
    const float in_front = transmittance;
    const Step step = composite(splat, at.x, at.y, transmittance, alpha);
    if (step == Step::blends) color += alpha * in_front * splat.color;
    stopped = step == Step::stops;
    return step;
  }

  glm::vec3 over(glm::vec3 background) const { return color + transmittance * background; }
};

struct FrameComparison {
  const Frame& all;
  const Frame& frame;
  glm::vec3 background;
  std::vector<std::uint32_t> slots;  // each Gaussian's slot in all.trace

  /// `marks`: per Gaussian of the cloud, 1 + the last tile that lists it, or 0.
  void one_tile(int tile, std::vector<int>& marks, MissedMap& map) const {
    for (const std::uint32_t gaussian : list_of(frame.trace, tile)) marks[gaussian] = tile + 1;
    const int side = all.grid.tile_px;
    const int x0 = tile % all.grid.columns * side, y0 = tile / all.grid.columns * side;
    for (int y = y0; y < std::min(y0 + side, map.height); ++y)
      for (int x = x0; x < std::min(x0 + side, map.width); ++x) one_pixel(tile, {x, y}, marks, map);
  }

  void one_pixel(int tile, glm::ivec2 pixel, const std::vector<int>& marks, MissedMap& map) const {
    const std::size_t at = static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(map.width) +
                           static_cast<std::size_t>(pixel.x);
    PixelState whole, kept;
    for (const std::uint32_t gaussian : list_of(all.trace, tile)) {
      if (whole.stopped && kept.stopped) break;
      const Splat& splat = all.trace.splats[slots[gaussian]];
      float alpha = 0;
      const bool listed = marks[gaussian] == tile + 1;
      if (listed) kept.take(splat, pixel, alpha);
      if (whole.take(splat, pixel, alpha) == Step::blends && !listed) {
        ++map.counts[at];
        map.alphas[at] = std::max(map.alphas[at], alpha);
      }
    }
    const glm::vec3 error = glm::abs(whole.over(background) - kept.over(background));
    map.errors[at] = std::max({error.x, error.y, error.z});
  }
};

}  // namespace

MissedMap missed_contributions(const Frame& all, const Frame& frame, glm::ivec2 size,
                               glm::vec3 background, ThreadPool& pool, std::stop_token stop) {
  const auto pixels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  MissedMap map{size.x, size.y, std::vector<std::uint32_t>(pixels), std::vector<float>(pixels),
                std::vector<float>(pixels)};
  const std::size_t gaussians = all.stats.gaussians;
  const FrameComparison comparison{all, frame, background, slots_of(all.trace, gaussians)};
  std::vector<std::vector<int>> marks(static_cast<std::size_t>(pool.size()));
  pool.for_chunks(static_cast<std::size_t>(all.grid.count()), 16,
                  [&](std::size_t begin, std::size_t end, int worker) {
                    if (stop.stop_requested()) throw Cancelled{};
                    std::vector<int>& own = marks[static_cast<std::size_t>(worker)];
                    own.resize(gaussians);
                    for (std::size_t tile = begin; tile < end; ++tile)
                      comparison.one_tile(static_cast<int>(tile), own, map);
                  });
  map.total = sum_of(map.counts);
  for (std::size_t i = 0; i < pixels; ++i) {
    map.pixels += map.counts[i] > 0;
    map.largest_alpha = std::max(map.largest_alpha, map.alphas[i]);
    map.largest_error = std::max(map.largest_error, map.errors[i]);
  }
  return map;
}

Heatmap missed_heatmap(const MissedMap& map) {
  Heatmap heatmap{HeatQuantity::missed, map.width, map.height, 1, map.counts};
  sum_up(heatmap);
  return heatmap;
}

std::string missed_sentence(const MissedMap& map) {
  if (map.total == 0) return "no contribution is missed";
  return fmt::format(
      "{} {} missed in {}, alpha up to {:.3f}, colour off by up "
      "to {:.3f}",
      counted(map.total, "contribution"), map.total == 1 ? "is" : "are",
      counted(map.pixels, "pixel"), map.largest_alpha, map.largest_error);
}

HeatmapMaker::HeatmapMaker(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                           HeatQuantity quantity, ThreadPool& pool, std::stop_token stop)
    : quantity_(quantity),
      size_(camera.width, camera.height),
      background_(settings.background),
      is_of_faces_(has_faces(settings.lens)),
      pool_(pool),
      stop_(std::move(stop)) {
  if (quantity > HeatQuantity::missed) {
    if (auto* const mapper = dynamic_cast<LevelMapper*>(&renderer))
      levels_ = mapper->level_map(camera, settings, quantity == HeatQuantity::error, stop_);
    levels_.resize(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y));
  }
  if (quantity != HeatQuantity::missed) return;
  RenderSettings baseline = settings;
  baseline.mode = kBaselineMode;
  baseline_ =
      renderer.render(camera, baseline, {.color = false, .trace = true}, HostImage{}, stop_);
}

Outputs HeatmapMaker::outputs() const {
  return baseline_ ? inspection_outputs() : outputs_for(quantity_);
}

FrameHeatmap HeatmapMaker::map(const Frame& frame) const {
  if (!levels_.empty()) {
    Heatmap heatmap{quantity_, size_.x, size_.y, 1, levels_};
    sum_up(heatmap);
    return {std::move(heatmap), std::nullopt};
  }
  if (!baseline_) {
    Heatmap heatmap = make_heatmap(frame, quantity_, size_.x, size_.y);
    heatmap.is_of_faces = is_of_faces_;
    return {std::move(heatmap), std::nullopt};
  }
  MissedMap missed = missed_contributions(*baseline_, frame, size_, background_, pool_, stop_);
  return {missed_heatmap(missed), std::move(missed)};
}

CullMode scale_mode(HeatQuantity quantity, CullMode baseline) {
  if (quantity != HeatQuantity::missed) return baseline;
  for (CullMode mode = 1; mode <= mode_count(); ++mode)
    if (!row_of(mode).lossless && !row_of(mode).keeps_faint) return mode;
  return baseline;
}

Scale scale_of_view(Renderer& renderer, const Camera& camera, RenderSettings settings,
                    HeatQuantity quantity, ThreadPool& pool, std::stop_token stop) {
  settings.mode = scale_mode(quantity, settings.mode);
  const HeatmapMaker maker(renderer, camera, settings, quantity, pool, stop);
  Outputs outputs = maker.outputs();
  outputs.color = false;
  const Frame& frame = renderer.render(camera, settings, outputs, HostImage{}, std::move(stop));
  return scale_for(maker.map(frame).heatmap.values);
}

HeatmapFrame render_with_heatmap(Renderer& renderer, const Camera& camera,
                                 const RenderSettings& settings, HeatQuantity quantity,
                                 ThreadPool& pool, std::stop_token stop) {
  const HeatmapMaker maker(renderer, camera, settings, quantity, pool, stop);
  const Frame& frame =
      renderer.render(camera, settings, maker.outputs(), HostImage{}, std::move(stop));
  return {maker.map(frame), frame};
}

}  // namespace qs
