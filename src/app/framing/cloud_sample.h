// SPDX-License-Identifier: MIT
//
// A sample of a cloud, from which a first view is chosen, so that the time does not depend on the
// size of the scene. The same cloud always gives the same sample.
#pragma once

#include <span>
#include <utility>
#include <vector>

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

}  // namespace qs
