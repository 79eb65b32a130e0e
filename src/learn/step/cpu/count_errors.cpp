// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>

#include "learn/gradient/error_map.h"
#include "learn/step/cpu/passes.h"
#include "raster/kernel/composite.h"

namespace qs::cpu::train {
namespace {

/// The bins of the errors, per pixel; pixels in bins above the limit are flagged.
struct ErrorMap {
  std::vector<std::uint16_t> bins;
  std::uint16_t limit = 0;

  ErrorMap(std::span<const glm::vec3> color, std::span<const glm::vec3> target,
           std::span<const std::uint8_t> mask)
      : bins(color.size()) {
    std::array<std::uint32_t, kErrorBins> histogram{};
    for (std::size_t i = 0; i < bins.size(); ++i) {
      const bool masked = !mask.empty() && mask[i] == 0;
      bins[i] = masked ? kMaskedError : error_bin(color[i], target[i]);
      if (!masked) ++histogram[bins[i]];
    }
    limit = error_limit(histogram.data());
  }
};

void add(std::vector<std::uint32_t>& counts, std::uint32_t gaussian, std::uint32_t pixels) {
  std::atomic_ref(counts[gaussian]).fetch_add(pixels, std::memory_order_relaxed);
}

void count_tile(const StepView& step, const ForwardFrame<float>& frame, const ErrorMap& errors,
                std::size_t tile, PixelCounts& counts) {
  const auto box = diff::TileBox::of(step.size(), tile);
  const std::uint64_t first = frame.lists.begin[tile];
  std::uint32_t longest = 0;
  for (int y = box.y0; y < box.y0 + box.height; ++y) {
    const auto row = frame.last.begin() + y * step.camera.width + box.x0;
    longest = std::max(longest, *std::max_element(row, row + box.width));
  }
  for (std::uint32_t entry = 0; entry < longest; ++entry) {
    const std::uint32_t slot = frame.lists.slots[first + entry];
    std::uint32_t blended = 0, flagged = 0;
    box.for_each_pixel(frame.areas[slot], [&](int x, int y, std::size_t /*pixel*/) {
      const auto at = static_cast<std::size_t>(y * step.camera.width + x);
      if (entry >= frame.last[at] || errors.bins[at] == kMaskedError) return;
      // No pixel stops before its last entry, so alpha alone decides.
      float alpha = 0, transmittance = 1;
      if (composite(frame.splats[slot], static_cast<float>(x), static_cast<float>(y), transmittance,
                    alpha) != Step::blends)
        return;
      ++blended;
      flagged += errors.bins[at] > errors.limit ? 1 : 0;
    });
    const std::uint32_t gaussian = frame.visible.gaussians[slot];
    if (blended > 0) add(counts.blended, gaussian, blended);
    if (flagged > 0) add(counts.flagged, gaussian, flagged);
  }
}

}  // namespace

void count_errors(const StepView& view, const ForwardFrame<float>& frame,
                  std::span<const glm::vec3> target, std::span<const std::uint8_t> mask,
                  std::size_t gaussians, PixelCounts& counts) {
  assert(target.size() == frame.color.size());
  counts.blended.resize(gaussians);
  counts.flagged.resize(gaussians);
  const ErrorMap errors(frame.color, target, mask);
  view.pool.for_each(view.size().tiles(), 1,
                     [&](std::size_t tile) { count_tile(view, frame, errors, tile, counts); });
}

}  // namespace qs::cpu::train
