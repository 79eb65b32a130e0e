// SPDX-License-Identifier: MIT
//
// The loss of a picture against a photograph (Kerbl et al. 2023), as both backends compute it:
//   (1 - w) L1 + w (1 - SSIM),   w = 0.2
// L1 is the mean of absolute differences over pixels and channels; SSIM is defined in
// scene/image_metrics.h. The picture is compared as it is shown: values are clamped to 0..1, and
// values outside that range have no derivative, as in the published training code. Masked pixels
// are not in the means and count as outside of both pictures. Photographs are stored with 8 bits
// per channel.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "raster/kernel/hd.h"
#include "raster/kernel/ssim.h"

namespace qs {

inline constexpr double kSsimWeight = 0.2;

struct Loss {
  double total = 0;
  double l1 = 0, ssim = 0;
  double squared_error = 0;  ///< mean over pixels and channels

  /// Makes the loss of sums over the `count` > 0 values that are not masked.
  static Loss of_sums(double l1, double ssim, double squared_error, double count) {
    Loss loss{0, l1 / count, ssim / count, squared_error / count};
    loss.total = (1 - kSsimWeight) * loss.l1 + kSsimWeight * (1 - loss.ssim);
    return loss;
  }
};

/// A value of the picture as it is shown.
template <class Real>
QS_HD Real shown(Real value) {
  return value < 0 ? Real(0) : value > 1 ? Real(1) : value;
}

/// The derivative of the loss by a value of the picture.
template <class Real>
struct LossGradient {
  Real l1_weight, ssim_weight;  ///< the weights of one value

  /// For a picture of `count` > 0 values that are not masked.
  static LossGradient of(double count) {
    return {static_cast<Real>((1 - kSsimWeight) / count), static_cast<Real>(kSsimWeight / count)};
  }

  /// `a` is the picture's value, `b` the photograph's; the others are similarity_by()'s.
  /// Equal values have no derivative of L1, values outside 0..1 none at all.
  QS_HD Real by(Real a, Real b, Real by_a, Real by_aa, Real by_ab) const {
    if (shown(a) != a) return 0;
    const Real difference = a - b;
    const auto sign = static_cast<Real>((difference > 0) - (difference < 0));
    return l1_weight * sign - ssim_weight * similarity_by(a, b, by_a, by_aa, by_ab);
  }
};

/// RGB, 0..1. `rgb` points to three values.
QS_HD glm::vec3 photograph_color(const std::uint8_t* rgb) {
  return {static_cast<float>(rgb[0]) / 255, static_cast<float>(rgb[1]) / 255,
          static_cast<float>(rgb[2]) / 255};
}

/// The background's share of a pixel with this alpha. Photographs with alpha are stored over black,
/// and this is added.
QS_HD glm::vec3 background_behind(std::uint8_t alpha, const glm::vec3& background) {
  return background * (1 - static_cast<float>(alpha) / 255);
}

}  // namespace qs
