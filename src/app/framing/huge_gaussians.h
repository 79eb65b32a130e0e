// SPDX-License-Identifier: MIT
//
// Gaussians that are larger than their scene. A failed training leaves such Gaussians, and a single
// one can cover every picture.
#pragma once

#include <cstddef>
#include <string>

#include "app/framing/scene_box.h"

namespace qs {

/// The standard deviation above which a Gaussian is larger than the scene, world units, > 0: the
/// diagonal of core_box(), but at least smallest_framing().
float scene_length(const SceneBox& core, float smallest);
float scene_length(const GaussianCloud& cloud);

/// Gaussians whose longest standard deviation is above `length`, a scene_length().
std::size_t count_huge(const GaussianCloud& cloud, float length);
inline std::size_t count_huge(const GaussianCloud& cloud) {
  return count_huge(cloud, scene_length(cloud));
}

/// Removes Gaussians above scene_length() and returns their number.
std::size_t drop_huge(GaussianCloud& cloud);

/// "3 Gaussians are larger than the scene", with the right form for 1.
std::string huge_text(std::size_t count);

}  // namespace qs
