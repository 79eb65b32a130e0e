// SPDX-License-Identifier: MIT
#include "app/inspect/pixel.h"

#include <algorithm>
#include <cassert>

#include "raster/kernel/composite.h"

namespace qs {

std::optional<std::size_t> slot_of(const Trace& trace, std::uint32_t gaussian) {
  const auto at = std::lower_bound(trace.gaussians.begin(), trace.gaussians.end(), gaussian);
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
    const Step step = composite(splat, static_cast<float>(pixel.x), static_cast<float>(pixel.y),
                                report.transmittance, here.alpha);
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

}  // namespace qs
