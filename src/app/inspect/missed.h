// SPDX-License-Identifier: MIT
//
// What a mode drops: contributions (alpha >= 1/255 in front of where the pixel stops) of Gaussians
// that its lists lack in the pixel's tile. Judged by the lists of a lossless mode, which lack none
// of them: their images are those of the fp64 reference but for rounding. A lossless mode misses
// nothing, `3dgs` what lies beyond three standard deviations, `dualbox` two quadrants.
#pragma once

#include <stop_token>
#include <vector>

#include "app/picture/heatmap.h"
#include "raster/base/parallel.h"

namespace qs {

struct MissedMap {
  int width = 0, height = 0;
  std::vector<std::uint32_t> counts;  ///< per pixel: contributions dropped
  std::vector<float> alphas;          ///< per pixel: the largest of their alphas, 0 without
  std::vector<float> errors;  ///< per pixel: largest difference of a channel that this makes, >= 0
  std::uint64_t total = 0;    ///< contributions
  std::uint64_t pixels = 0;   ///< that miss any
  float largest_alpha = 0, largest_error = 0;
};

/// The mode that judges.
inline constexpr CullMode kJudgeMode = find_culler("adr");

/// Both frames are of one view and were drawn with Outputs::trace, `all` in kJudgeMode. `size`: of
/// the image. Throws Cancelled.
MissedMap missed_contributions(const Frame& all, const Frame& frame, glm::ivec2 size,
                               glm::vec3 background, ThreadPool& pool, std::stop_token stop = {});

/// The counts as a heat map of HeatQuantity::missed.
Heatmap missed_heatmap(const MissedMap& map);

/// "12 contributions in 3 pixels, alpha up to 0.2, color off by up to 0.1".
std::string missed_sentence(const MissedMap& map);

}  // namespace qs
