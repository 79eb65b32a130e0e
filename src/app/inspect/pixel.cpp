// SPDX-License-Identifier: MIT
#include "app/inspect/pixel.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "base/error.h"
#include "raster/kernel/composite.h"
#include "raster/kernel/cull/culler.h"

namespace qs {
namespace {

PixelBox pixels_of(const TileGrid& grid, glm::ivec2 size, int tile) {
  const int x = tile % grid.columns * grid.tile_px, y = tile / grid.columns * grid.tile_px;
  return {x, y, std::min(x + grid.tile_px, size.x), std::min(y + grid.tile_px, size.y)};
}

/// Conservative bound of the pixels of the tile in which the Gaussian reaches 1/255.
PixelBox reached(const PixelBox& tile, const Footprint& footprint) {
  if (!(footprint.gamma > 0)) return {};
  const glm::vec2 half = extents(footprint).max + 1.0f, mean = footprint.mean_px;
  const auto clamped = [](float value, int low, int high) {
    return low + clamp_to_int(value - static_cast<float>(low), high - low);
  };
  return {clamped(mean.x - half.x, tile.x0, tile.x1), clamped(mean.y - half.y, tile.y0, tile.y1),
          clamped(mean.x + half.x + 1, tile.x0, tile.x1),
          clamped(mean.y + half.y + 1, tile.y0, tile.y1)};
}

/// Calls visit(x, y) for the pixels of the box, row by row.
template <class Visit>
void for_each_pixel(const PixelBox& box, Visit&& visit) {
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) visit(x, y);
}

Step composite_at(const Splat& splat, int x, int y, float& transmittance, float& alpha) {
  return composite(splat, static_cast<float>(x), static_cast<float>(y), transmittance, alpha);
}

/// True if alpha reaches 1/255 at a pixel of the box.
bool reaches(const Splat& splat, const PixelBox& box) {
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      float left = 1, alpha = 0;
      if (composite_at(splat, x, y, left, alpha) != Step::skips) return true;
    }
  }
  return false;
}

void uses_in_tile(const Frame& frame, glm::ivec2 size, const std::vector<std::uint32_t>& slots,
                  int tile, std::vector<PairUse>& uses) {
  const Trace& trace = frame.trace;
  const PixelBox pixels = pixels_of(frame.grid, size, tile);
  const int width = pixels.x1 - pixels.x0;
  int running = width * (pixels.y1 - pixels.y0);
  // The transmittance of the pixels; 0: the pixel has stopped.
  std::vector<float> transmittance(static_cast<std::size_t>(running), 1.0f);
  const std::uint64_t end = trace.tile_begin[static_cast<std::size_t>(tile) + 1];
  for (std::uint64_t k = trace.tile_begin[static_cast<std::size_t>(tile)]; k < end; ++k) {
    const std::uint32_t slot = slots[trace.listed[k]];
    const Splat& splat = trace.splats[slot];
    const PixelBox box = reached(pixels, trace.footprints[slot]);
    bool blended = false, stopped = false;
    for_each_pixel(running > 0 ? box : PixelBox{}, [&](int x, int y) {
      float& left =
          transmittance[static_cast<std::size_t>((y - pixels.y0) * width + x - pixels.x0)];
      if (left == 0) return;
      float alpha = 0;
      const Step step = composite_at(splat, x, y, left, alpha);
      blended = blended || step == Step::blends;
      if (step != Step::stops) return;
      stopped = true;
      left = 0;
      --running;
    });
    const bool hidden = !blended && (stopped || reaches(splat, box));
    uses[k] = blended ? PairUse::used : hidden ? PairUse::hidden : PairUse::empty;
  }
}

/// True if `other` is composited before the Gaussian in `slot`.
bool in_front(const Trace& trace, std::size_t other, std::size_t slot) {
  const auto key = [&](std::size_t s) {
    return std::pair(std::bit_cast<std::uint32_t>(trace.depths[s]), trace.gaussians[s]);
  };
  return key(other) < key(slot);
}

}  // namespace

std::optional<std::size_t> slot_of(const Trace& trace, std::uint32_t gaussian) {
  const auto at = std::ranges::lower_bound(trace.gaussians, gaussian);
  if (at == trace.gaussians.end() || *at != gaussian) return std::nullopt;
  return static_cast<std::size_t>(at - trace.gaussians.begin());
}

std::vector<std::uint32_t> slots_of(const Trace& trace, std::size_t size) {
  std::vector<std::uint32_t> slots(size, 0xffffffffu);
  for (std::size_t slot = 0; slot < trace.gaussians.size(); ++slot)
    slots[trace.gaussians[slot]] = static_cast<std::uint32_t>(slot);
  return slots;
}

std::span<const std::uint32_t> list_of(const Trace& trace, int tile) {
  const std::size_t lists = trace.tile_begin.size() - 1;
  const std::size_t list = lists == 1 ? 0 : static_cast<std::size_t>(tile);
  return std::span(trace.listed)
      .subspan(trace.tile_begin[list], trace.tile_begin[list + 1] - trace.tile_begin[list]);
}

PixelReport inspect_pixel(const Frame& frame, glm::ivec2 pixel, glm::vec3 background) {
  const Trace& trace = frame.trace;
  assert(!trace.tile_begin.empty());
  PixelReport report;
  report.pixel = pixel;
  report.tile = frame.grid.tile_of(pixel.x, pixel.y);
  const std::span<const std::uint32_t> list = list_of(trace, report.tile);
  report.listed = static_cast<std::uint32_t>(list.size());
  for (const std::uint32_t gaussian : list) {
    ++report.evaluated;
    const std::size_t slot = *slot_of(trace, gaussian);
    const Splat& splat = trace.splats[slot];
    Contribution here{gaussian, trace.depths[slot], 0, report.transmittance, 0, splat.color};
    const Step step = composite_at(splat, pixel.x, pixel.y, report.transmittance, here.alpha);
    if (step == Step::stops) {
      report.stopped_by = here;
      break;
    }
    if (step == Step::skips) continue;
    here.weight = here.alpha * here.transmittance;
    report.color += here.weight * here.color;
    report.contributions.push_back(here);
  }
  report.color += report.transmittance * background;
  return report;
}

std::vector<PairUse> pair_uses(const Frame& frame, glm::ivec2 size, ThreadPool& pool,
                               std::stop_token stop) {
  std::vector<PairUse> uses(frame.trace.listed.size());
  const std::vector<std::uint32_t> slots = slots_of(frame.trace, frame.stats.gaussians);
  pool.for_chunks(static_cast<std::size_t>(frame.grid.count()), 16,
                  [&](std::size_t begin, std::size_t end, int) {
                    if (stop.stop_requested()) throw Cancelled{};
                    for (std::size_t tile = begin; tile < end; ++tile)
                      uses_in_tile(frame, size, slots, static_cast<int>(tile), uses);
                  });
  return uses;
}

PairUses sum_up(const std::vector<PairUse>& uses) {
  PairUses sums;
  std::uint64_t* const totals[] = {&sums.used, &sums.hidden, &sums.empty};
  for (const PairUse use : uses) ++*totals[static_cast<int>(use)];
  return sums;
}

PairUse use_in_tile(const Frame& frame, glm::ivec2 size, std::size_t slot, int tile) {
  const Trace& trace = frame.trace;
  const PixelBox box = reached(pixels_of(frame.grid, size, tile), trace.footprints[slot]);
  std::vector<std::size_t> before;
  for (const std::uint32_t gaussian : list_of(trace, tile)) {
    const std::size_t other = *slot_of(trace, gaussian);
    if (in_front(trace, other, slot)) before.push_back(other);
  }
  PairUse use = PairUse::empty;
  for_each_pixel(box, [&](int x, int y) {
    float alpha = 0, left = 1;
    if (use == PairUse::used) return;
    if (composite_at(trace.splats[slot], x, y, left, alpha) == Step::skips) return;
    use = PairUse::hidden;
    left = 1;
    for (const std::size_t other : before)
      if (composite_at(trace.splats[other], x, y, left, alpha) == Step::stops) return;
    if (composite_at(trace.splats[slot], x, y, left, alpha) == Step::blends) use = PairUse::used;
  });
  return use;
}

}  // namespace qs
