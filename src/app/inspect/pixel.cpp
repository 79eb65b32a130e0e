// SPDX-License-Identifier: MIT
#include "app/inspect/pixel.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "base/error.h"
#include "raster/kernel/composite.h"

namespace qs {
namespace {

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
