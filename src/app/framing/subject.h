// SPDX-License-Identifier: MIT
//
// The Gaussians from which a first view is chosen: a sample of the cloud, so that the time does not
// depend on the size of the scene; its subject, the dense parts without floaters and thin
// surroundings; and the subject's extents in the horizontal plane of the world. The same cloud
// always gives the same result.
#pragma once

#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "app/framing/scene_box.h"
#include "io/scene/reader.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

struct CloudSample {
  GaussianCloud gaussians;       ///< with the base colour only
  std::vector<float> opacities;  ///< 0..1; all 1 if all of them are 0
  double represented = 1;        ///< Gaussians of the cloud per Gaussian of the sample, >= 1
};

/// At most `most` Gaussians at equal distances in the order of the cloud. Leaves out Gaussians with
/// values that are not numbers, with infinite positions or sizes, and all that drop_huge() removes.
CloudSample sample_of(const GaussianCloud& cloud, std::size_t most);

/// Makes the sample from one that a reader took with `most` as its Sampling::most.
CloudSample sample_of(const SceneSample& sample);

/// Weighted quantiles.
class Quantiles {
 public:
  Quantiles(std::span<const double> values, std::span<const float> weights);
  /// The least value with which the fraction of the weights' sum is reached; 0 without values.
  double at(double fraction) const;

 private:
  std::vector<std::pair<double, double>> sorted_;  // values and the sums of the weights up to them
};

/// The range of a scene along an axis: low <= high, world units.
struct Extent {
  double low = 0, high = 0;
  double size() const { return high - low; }
  /// -1 at `low`, 1 at `high`.
  double place_of(double value) const {
    return high > low ? (2 * value - low - high) / (high - low) : 0;
  }
  double value_at(double place) const { return 0.5 * (low + high + place * (high - low)); }
};

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

/// The horizontal plane of a world, and a subject's extents in it.
struct Ground {
  /// Unit vectors. `forward` is the usual viewing direction: +z or, if that is vertical, +y. It is
  /// turned by up to 45 degrees if that makes the box below clearly smaller, as in a street.
  glm::dvec3 up, forward, right;
  /// The opacity-weighted 5th to 95th percentile of the subject in these axes.
  Extent height, ahead, aside;

  Ground(const Subject& subject, glm::dvec3 upward);

  /// A horizontal direction; azimuth 0 is `forward`.
  glm::dvec3 direction(double azimuth) const {
    return std::cos(azimuth) * forward + std::sin(azimuth) * right;
  }
  /// From -1 at one border of the subject to 1 at the other, along `right` and `forward`.
  glm::dvec2 place_of(glm::dvec3 position) const {
    return {aside.place_of(glm::dot(position, right)), ahead.place_of(glm::dot(position, forward))};
  }
  glm::dvec3 position_of(glm::dvec2 place, double at_height) const {
    return aside.value_at(place.x) * right + ahead.value_at(place.y) * forward + at_height * up;
  }
};

}  // namespace qs
