// SPDX-License-Identifier: MIT
//
// The Gaussians that a pixel blends, front to back, computed from the trace of a frame. Works with
// the traces of all backends and of mode reference, which has one list for its whole region.
// Also classifies pairs (a Gaussian listed in a tile). A pair that no pixel blends is a false
// positive: either empty, because alpha reaches 1/255 at no pixel centre of the tile, and a tighter
// bound would avoid it; or hidden, because all pixels that it reaches have stopped before it. No
// bound can detect hidden pairs. So mode `exact` has false positives too.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "raster/api/renderer.h"
#include "raster/api/trace.h"

namespace qs {

/// The contribution of a Gaussian to a pixel.
struct Contribution {
  std::uint32_t gaussian = 0;  ///< index in the cloud
  float depth = 0;             ///< view z
  float alpha = 0;             ///< 1/255 .. 0.99
  float transmittance = 1;     ///< transmittance in front of it
  float weight = 0;            ///< alpha times transmittance; 0 if the pixel stops here
  glm::vec3 color{0.0f};
};

struct PixelReport {
  glm::ivec2 pixel{0};
  int tile = 0;
  std::uint32_t listed = 0;     ///< Gaussians in the tile's list
  std::uint32_t evaluated = 0;  ///< list entries that are evaluated until the pixel stops
  std::vector<Contribution> contributions;  ///< front to back
  std::optional<Contribution> stopped_by;
  float transmittance = 1;  ///< the weight of the background, behind all contributions
  glm::vec3 color{0.0f};
};

/// `pixel` must be inside the frame's image.
PixelReport inspect_pixel(const Frame& frame, glm::ivec2 pixel, glm::vec3 background);

/// From best to worst.
enum class PairUse : std::uint8_t {
  used,    ///< a pixel blends it
  hidden,  ///< alpha reaches 1/255, but only at pixels that have stopped
  empty,   ///< alpha reaches 1/255 at no pixel
};

struct PairUses {
  std::uint64_t used = 0, hidden = 0, empty = 0;
  std::uint64_t false_positives() const { return hidden + empty; }
  std::uint64_t pairs() const { return used + hidden + empty; }
};

/// The use of every pair, parallel to Trace::listed. `size`: of the image. Throws Cancelled.
std::vector<PairUse> pair_uses(const Frame& frame, glm::ivec2 size, ThreadPool& pool,
                               std::stop_token stop = {});

PairUses sum_up(const std::vector<PairUse>& uses);

/// The use of a pair of the Gaussian in `slot` of the trace and a tile. The tile need not list the
/// Gaussian.
PairUse use_in_tile(const Frame& frame, glm::ivec2 size, std::size_t slot, int tile);

}  // namespace qs
