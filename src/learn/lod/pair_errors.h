// SPDX-License-Identifier: MIT
//
// merging_error() of many pairs at a time, in vectors. The values equal the plain function's within
// rounding, and do not depend on the number of pairs.
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

/// The variance of the filter at which pairs are judged: `v`, and `of_size` times the area of the
/// merged node / 4 pi.
struct PairFilter {
  float v = 0, of_size = 0;
  bool antialiased = false;
};

/// errors[i]: the error of merging Gaussian `a` + i of `first` and `b` + i of `second`, i < count.
void pair_errors(const LodPlanes& first, std::size_t a, const LodPlanes& second, std::size_t b,
                 std::size_t count, const PairFilter& filter, float* errors);

}  // namespace qs
