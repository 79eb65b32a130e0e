// SPDX-License-Identifier: MIT
#include "app/inspect/inspection.h"

#include <algorithm>
#include <map>

#include "base/fail.h"

namespace qs {
namespace {

std::optional<std::uint32_t> heaviest(const PixelReport& pixel) {
  const auto& all = pixel.contributions;
  const auto best = std::max_element(
      all.begin(), all.end(),
      [](const Contribution& a, const Contribution& b) { return a.weight < b.weight; });
  if (best == all.end()) return std::nullopt;
  return best->gaussian;
}

}  // namespace

Outputs inspection_outputs() {
  Outputs outputs;
  outputs.trace = true;
  return outputs;
}

Inspection inspect(const Frame& frame, glm::ivec2 size, glm::ivec2 pixel, glm::vec3 background,
                   std::optional<std::uint32_t> gaussian) {
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= size.x || pixel.y >= size.y) {
    fail(ErrorKind::usage, "inspect: there is no pixel {},{}: the picture is {} x {}", pixel.x,
         pixel.y, size.x, size.y);
  }
  Inspection result;
  result.pixel = inspect_pixel(frame, pixel, background);
  const std::optional<std::uint32_t> picked = gaussian ? gaussian : heaviest(result.pixel);
  if (!picked) return result;
  const std::optional<std::size_t> slot = slot_of(frame.trace, *picked);
  if (!slot) {
    fail(ErrorKind::usage,
         "inspect: Gaussian {} is not visible in this view and mode, in which {} of the scene's "
         "{} Gaussians are",
         *picked, frame.stats.visible, frame.stats.gaussians);
  }
  result.gaussian = inspect_gaussian(frame.trace, *slot, frame.grid);
  std::map<int, PairUse> known;  // modes share most of their tiles
  for (const ModeTiles& mode : result.gaussian->modes) {
    std::vector<PairUse>& uses = result.uses.emplace_back();
    for (const int tile : mode.tiles) {
      const auto [at, is_new] = known.try_emplace(tile, PairUse::empty);
      if (is_new) at->second = use_in_tile(frame, size, *slot, tile);
      uses.push_back(at->second);
    }
  }
  return result;
}

PairUses uses_of(const Inspection& inspection, std::size_t mode_index) {
  return sum_up(inspection.uses[mode_index]);
}

}  // namespace qs
