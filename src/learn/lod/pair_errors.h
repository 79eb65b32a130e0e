// SPDX-License-Identifier: MIT
//
// The closed form of the difference between the pictures of a pair and of its node, for many pairs
// at a time, in vectors.
#pragma once

#include <cstddef>
#include <vector>

#include "learn/lod/merging.h"

namespace qs {

/// Gaussians as planes of floats.
class LodPlanes {
 public:
  static constexpr std::size_t kPlanes = 12 + kLodColors;

  void resize(std::size_t count);
  void set(std::size_t i, const LodGaussian& gaussian);

  /// Readable up to 16 values behind the last Gaussian.
  const float* plane(std::size_t k) const { return values_.data() + k * stride_; }

 private:
  std::vector<float> values_;
  std::size_t stride_ = 0;
};

/// The variance of the renderer's filter at which pairs are judged, world units^2: `v`, which is
/// 0.3 h^2 for pixels of the side h, and `of_size` times the area of the merged node / 4 pi.
/// `antialiased`: the filter keeps the light of each Gaussian.
struct PairFilter {
  float v = 0, of_size = 0;
  bool antialiased = false;
};

/// errors[i], i < count: the error of merging Gaussian `a` + i of `first` and `b` + i of `second`.
/// This is the integral of the squared difference between the pictures of the pair and of the node:
/// mean over three directions of sight and over grey backgrounds, sum over RGB; colour^2 times
/// world units^2. Overlapping Gaussians add up, so this estimates and does not bound the difference
/// where Gaussians hide each other. Finite for all finite Gaussians; a pair's error depends on it
/// alone.
void pair_errors(const LodPlanes& first, std::size_t a, const LodPlanes& second, std::size_t b,
                 std::size_t count, const PairFilter& filter, float* errors);

}  // namespace qs
