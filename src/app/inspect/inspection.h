// SPDX-License-Identifier: MIT
//
// The data that the inspector shows: a pixel, one of its Gaussians, and the use of its pairs in
// every mode, as text and as JSON. The command and the panel draw it.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "app/inspect/gaussian.h"
#include "app/inspect/pixel.h"

namespace qs {

struct Inspection {
  PixelReport pixel;
  std::optional<GaussianReport> gaussian;  ///< the picked Gaussian; unset if the pixel blends none
  std::vector<std::vector<PairUse>> uses;  ///< parallel to gaussian->modes and their tiles
};

/// `frame` was rendered with inspection_outputs(); its image has `size` pixels. `gaussian`: index
/// in the cloud of the Gaussian to pick, default: the Gaussian with the largest weight in the
/// pixel. Throws Error(usage) if it is not visible in the frame, or if `pixel` is outside the
/// image.
Inspection inspect(const Frame& frame, glm::ivec2 size, glm::ivec2 pixel, glm::vec3 background,
                   std::optional<std::uint32_t> gaussian = std::nullopt);

Outputs inspection_outputs();

/// Sums of the uses of a mode's tiles. `mode_index` = CullMode - 1.
PairUses uses_of(const Inspection& inspection, std::size_t mode_index);

struct InspectedFact {
  std::string label, value;
};

/// The picked Gaussian's numbers with their units.
std::vector<InspectedFact> gaussian_facts(const GaussianReport& gaussian);

/// Tables of the pixel's Gaussians and of the picked Gaussian. UTF-8, ends with a newline.
std::string format_inspection(const Inspection& inspection);

/// Everything in full precision; lengths in pixels, angles in radians.
nlohmann::ordered_json inspection_json(const Inspection& inspection);

}  // namespace qs
