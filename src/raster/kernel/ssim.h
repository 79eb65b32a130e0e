// SPDX-License-Identifier: MIT
//
// Structural similarity (Wang et al. 2004) of one value of a picture, and its derivatives. The
// weights of the window are ssim_window() of scene/image_metrics.h.
#pragma once

#include "raster/kernel/hd.h"

namespace qs {

inline constexpr int kSsimRadius = 5;  ///< px, of the window
inline constexpr int kSsimSize = 2 * kSsimRadius + 1;
inline constexpr double kSsimC1 = 0.01 * 0.01, kSsimC2 = 0.03 * 0.03;

/// The means of a, b, a^2, b^2 and ab in the window, where no derivatives are needed.
struct SsimMeans {
  double a, b, aa, bb, ab;

  static QS_HD SsimMeans of(double a, double b) { return {a, b, a * a, b * b, a * b}; }
  QS_HD void add(double weight, const SsimMeans& m) {
    a += weight * m.a;
    b += weight * m.b;
    aa += weight * m.aa;
    bb += weight * m.bb;
    ab += weight * m.ab;
  }
  /// 1 if both pictures are equal in the window.
  QS_HD double similarity() const {
    const double variance_a = aa - a * a, variance_b = bb - b * b, covariance = ab - a * b;
    return (2 * a * b + kSsimC1) * (2 * covariance + kSsimC2) /
           ((a * a + b * b + kSsimC1) * (variance_a + variance_b + kSsimC2));
  }
};

/// SSIM from the means of a, b, a^2, b^2 and ab in the window, and its derivatives by the means
/// that contain the picture a.
template <class Real>
struct Similarity {
  Real value, by_a, by_aa, by_ab;

  static QS_HD Similarity of(Real a, Real b, Real aa, Real bb, Real ab) {
    constexpr Real kC1 = Real(kSsimC1), kC2 = Real(kSsimC2);
    const Real top1 = 2 * a * b + kC1, top2 = 2 * (ab - a * b) + kC2;
    const Real bottom1 = a * a + b * b + kC1, bottom2 = aa - a * a + bb - b * b + kC2;
    const Real inverse = 1 / (bottom1 * bottom2);
    const Real value = top1 * top2 * inverse;
    return {value, 2 * b * (top2 - top1) * inverse + 2 * a * value * (1 / bottom2 - 1 / bottom1),
            -value / bottom2, 2 * top1 * inverse};
  }
};

/// The derivative of a sum of SSIM by the value a of a picture, which was compared with the value
/// b. The others are Similarity's derivatives, summed over the windows that reach the value.
template <class Real>
QS_HD Real similarity_by(Real a, Real b, Real by_a, Real by_aa, Real by_ab) {
  return by_a + 2 * a * by_aa + b * by_ab;
}

}  // namespace qs
