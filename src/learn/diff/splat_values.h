// SPDX-License-Identifier: MIT
//
// From a projected Gaussian to the values that pixels read of it.
#pragma once

#include <type_traits>

#include "learn/gradient/gaussian.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/hd.h"

namespace qs::diff {

/// The values that pixels read of a Gaussian, without its colour.
template <class Real>
struct SplatValues {
  glm::vec<2, Real> mean_px;
  glm::vec<3, Real> conic;
  Real depth, opacity;

  /// `projected` is the Gaussian's footprint in single precision; in double precision the values
  /// are computed again. `Rules` has the members of GradientRules.
  template <class Rules>
  static QS_HD SplatValues of(const Rules& rules, const glm::vec<3, Real>& mean,
                              const Covariance3<double>& sigma, double opacity,
                              const Projected& projected) {
    if constexpr (std::is_same_v<Real, float>) {
      return {projected.footprint.mean_px, projected.footprint.conic, projected.depth,
              static_cast<float>(opacity) * projected.opacity_factor};
    } else {
      const glm::dvec3 point = to_view(rules.view, mean);
      const auto covariance = ImageCovariance<double>::of(rules, point, sigma);
      const Covariance2<double>& c = covariance.after;
      const double determinant = c.determinant();
      if (rules.antialiased) {
        opacity *= compensation(covariance.before.determinant(), determinant,
                                double{rules.compensation_floor});
      }
      return {to_pixel(rules.view, point), glm::dvec3(c.yy, -c.xy, c.xx) / determinant, point.z,
              opacity};
    }
  }
};

}  // namespace qs::diff
