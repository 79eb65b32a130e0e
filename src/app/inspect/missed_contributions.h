// SPDX-License-Identifier: MIT
//
// The contributions (alpha >= 1/255 before the pixel stops) that a mode drops, because its lists
// lack the Gaussian in the pixel's tile. They are found by comparing with a frame of a lossless
// mode, whose lists are complete. Mode `3dgs` drops contributions beyond three standard deviations,
// `dualbox` drops contributions in two quadrants.
#pragma once

#include <stop_token>
#include <vector>

#include "app/picture/heatmap.h"
#include "base/parallel.h"

namespace qs {

struct MissedMap {
  int width = 0, height = 0;
  std::vector<std::uint32_t> counts;  ///< contributions dropped, for each pixel
  std::vector<float> alphas;          ///< the largest of their alphas, or 0, for each pixel
  std::vector<float> errors;  ///< largest error of a channel because of them, >= 0, for each pixel
  std::uint64_t total = 0;    ///< contributions
  std::uint64_t pixels = 0;   ///< pixels with at least one
  float largest_alpha = 0, largest_error = 0;
};

/// A lossless mode: its lists contain every contribution.
inline const CullMode kBaselineMode = find_culler("adr");

/// Both frames show one view of `size` pixels and were rendered with Outputs::trace, `all` in
/// kBaselineMode. Throws Cancelled.
MissedMap missed_contributions(const Frame& all, const Frame& frame, glm::ivec2 size,
                               glm::vec3 background, ThreadPool& pool, std::stop_token stop = {});

/// The counts as a heat map of HeatQuantity::missed.
Heatmap missed_heatmap(const MissedMap& map);

/// "12 contributions are missed in 3 pixels, alpha up to 0.2, color off by up to 0.1"
std::string missed_sentence(const MissedMap& map);

}  // namespace qs
