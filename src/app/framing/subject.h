// SPDX-License-Identifier: MIT
//
// The subject of a scene: its dense parts, without floaters and thin surroundings.
#pragma once

#include <vector>

#include "app/framing/cloud_sample.h"
#include "app/framing/scene_box.h"

namespace qs {

struct Subject {
  std::vector<std::uint8_t> holds;   ///< 0 or 1 per Gaussian of the sample
  std::vector<glm::vec3> positions;  ///< the positions of the Gaussians that it holds
  std::vector<float> weights;        ///< their opacities
  SceneBox box;                      ///< the weighted 5th to 95th percentile of the positions
};

/// Least densities of opacity, as factors on the typical density: of the whole scene, and of its
/// subject, the part that its pictures capture best.
inline constexpr double kSceneDensity = 0.03, kSubjectDensity = 0.4;

/// The Gaussians of a sample where the density of opacity is at least `least_density` times the
/// typical density, without isolated groups of less than 10 % of the largest group.
Subject find_subject(const CloudSample& sample, double least_density);

}  // namespace qs
