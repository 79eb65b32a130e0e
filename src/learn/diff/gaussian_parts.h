// SPDX-License-Identifier: MIT
//
// Parts of a trainer that compute every Gaussian for itself, in a caller's arrays. A struct has the
// arrays; called with the number of a Gaussian, it computes this one, on every backend.
#pragma once

#include <cmath>
#include <cstdint>

#include "learn/diff/strided_arrays.h"
#include "learn/gradient/activation.h"
#include "learn/gradient/density.h"
#include "learn/gradient/relocation.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/hd.h"

namespace qs::diff {

/// Symmetric matrices of 6 numbers, xx xy xz yy yz zz, or of 3 x 3.
struct Covariances {
  Rows<const float> rotations, scales;  ///< quaternions w x y z of any length; standard deviations
  float* data;
  std::ptrdiff_t row, line, column;  ///< strides; line 0: 6 numbers

  QS_HD void operator()(std::size_t i) const {
    const Covariance3<float> c =
        scaled_covariance(scales.vec3(i), unit_rotation(rotations.quaternion(i)));
    float* const to = data + static_cast<std::ptrdiff_t>(i) * row;
    const float packed[] = {c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
    if (line == 0) {
      for (int k = 0; k < 6; ++k) to[k * column] = packed[k];
      return;
    }
    constexpr int kFirst[] = {0, 2, 3};  // of a line in `packed`, less the line's number
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        to[j * line + k * column] = packed[j <= k ? kFirst[j] + k : kFirst[k] + j];
  }
};

/// Rows of 2 numbers times x and y, for derivatives in other units. A third number becomes 0.
template <class Real>
struct RowScale {
  Rows<Real> rows;
  Real x, y;
  bool has_third;

  QS_HD void operator()(std::size_t i) const {
    rows.at(i) *= x;
    rows.at(i, 1) *= y;
    if (has_third) rows.at(i, 2) = 0;
  }
};

/// The values of Gaussians as they are trained, and standard normal vectors.
struct NoisyMeans {
  Rows<float> means;
  Rows<const float> log_scales, rotations, opacity_logits, normals;
  NoiseShape shape;

  QS_HD void operator()(std::size_t i) const {
    means.set(i, shape.moved(means.vec3(i), log_scales.vec3(i), rotations.quaternion(i),
                             opacity_logits.at(i), glm::dvec3(normals.vec3(i))));
  }
};

/// Adds the derivatives of a view by the centres to sums per Gaussian.
struct ViewSums {
  Rows<const float> gradients;
  Rows<const std::int32_t> radii;  ///< 0: the view does not show the Gaussian
  float x, y;                      ///< factors of the derivatives
  Rows<float> lengths, views;

  QS_HD void operator()(std::size_t i) const {
    if (radii.at(i) <= 0 || radii.at(i, 1) <= 0) return;
    const float along_x = gradients.at(i) * x, along_y = gradients.at(i, 1) * y;
    lengths.at(i) += std::sqrt(along_x * along_x + along_y * along_y);
    views.at(i) += 1;
  }
};

/// `Count` is an integer type of 32 or 64 bits.
template <class Count>
struct Relocations {
  Rows<const float> opacities, scales;
  Rows<const Count> counts;
  Rows<float> new_opacities, new_scales;

  QS_HD void operator()(std::size_t i) const {
    const Count given = counts.at(i);
    const bool is_usual = given >= Count(1) && given < Count(kMostCopies);
    const int copies = is_usual ? static_cast<int>(given) : given < Count(1) ? 1 : kMostCopies;
    const Relocation shared = shared_place(static_cast<double>(opacities.at(i)), copies);
    for (int axis = 0; axis < 3; ++axis)
      new_scales.at(i, axis) =
          static_cast<float>(static_cast<double>(scales.at(i, axis)) * shared.scale_factor);
    new_opacities.at(i) = static_cast<float>(shared.opacity);
  }
};

}  // namespace qs::diff
