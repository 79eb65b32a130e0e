// SPDX-License-Identifier: MIT
//
// Everything that the inspector shows: a pixel, one of its Gaussians, and what became of the pairs
// of every mode. Command and panels make text and drawings of it.
#pragma once

#include "app/inspect/gaussian.h"
#include "app/inspect/pair_use.h"
#include "app/inspect/pixel.h"

namespace qs {

struct Inspection {
  PixelReport pixel;
  std::optional<GaussianReport> gaussian;  ///< the picked one; unset when the pixel shows none
  std::vector<std::vector<PairUse>> uses;  ///< parallel to gaussian->modes and their tiles
};

/// From a frame drawn with inspection_outputs(). `gaussian`: the one to pick, by its index in the
/// cloud; unset = the one with the largest weight in the pixel. Throws Error(usage) when the frame
/// does not show it, or `pixel` lies outside the image of `size`.
Inspection inspect(const Frame& frame, glm::ivec2 size, glm::ivec2 pixel, glm::vec3 background,
                   std::optional<std::uint32_t> gaussian = std::nullopt);

Outputs inspection_outputs();

/// How many of a mode's tiles came to what.
PairUses uses_of(const Inspection& inspection, std::size_t mode_index);

}  // namespace qs
