// SPDX-License-Identifier: MIT
//
// Crop boxes and removals as words of the command line and of the window.
#pragma once

#include <string>
#include <string_view>

#include "raster/scene/removal.h"

namespace qs {

/// X0,Y0,Z0,X1,Y1,Z1 in world units, each within +-1e9. Throws Error(usage) "WHAT: ..."; `what` is
/// the option's name.
/// `origin`: of the cloud to crop; the words count from 0, the box from there.
CropBox parse_crop_box(std::string_view what, std::string_view text,
                       const glm::dvec3& origin = glm::dvec3(0));

/// The words that parse_crop_box() reads.
std::string format_crop_box(const CropBox& box, const glm::dvec3& origin = glm::dvec3(0));

/// "12 of 34,321 Gaussians VERB: 3 outside of the box, 9 isolated", without reasons of 0.
std::string removal_text(const RemovalCounts& removal, std::string_view verb);

}  // namespace qs
