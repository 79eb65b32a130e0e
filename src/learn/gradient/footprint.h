// SPDX-License-Identifier: MIT
//
// Gradients of a footprint: its conic and its opacity compensation, by the covariance on the image.
// A symmetric matrix has one value per pair of equal elements, so the derivative by xy counts both.
#pragma once

#include <cmath>

#include <glm/vec3.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/hd.h"
#include "raster/kernel/project.h"

namespace qs {

/// Adds d_determinant times the derivative of the covariance's determinant.
template <class Real>
QS_HD void add_determinant_gradient(const Covariance2<Real>& covariance, Real d_determinant,
                                    Covariance2<Real>& sum) {
  sum.xx += d_determinant * covariance.yy;
  sum.xy -= d_determinant * 2 * covariance.xy;
  sum.yy += d_determinant * covariance.xx;
}

/// Passes derivatives on from the conic (yy, -xy, xx) / determinant to the dilated covariance,
/// whose determinant must be > 0.
template <class Real>
QS_HD Covariance2<Real> conic_gradient(const Covariance2<Real>& covariance,
                                       const glm::vec<3, Real>& d_conic) {
  const Real inverse = 1 / covariance.determinant();
  Covariance2<Real> result{d_conic.z * inverse, -d_conic.y * inverse, d_conic.x * inverse};
  const Real d_determinant =
      -inverse * inverse *
      (d_conic.x * covariance.yy - d_conic.y * covariance.xy + d_conic.z * covariance.xx);
  add_determinant_gradient(covariance, d_determinant, result);
  return result;
}

/// Passes derivatives on from the factor compensation(before, after) to the covariance, which is
/// `before` without and `after` with the dilation. Nothing where their ratio is at its lower bound.
template <class Real>
QS_HD Covariance2<Real> compensation_gradient(const Covariance2<Real>& before,
                                              const Covariance2<Real>& after, Real d_factor,
                                              Real floor = Real(kCompensationFloor)) {
  Covariance2<Real> result{0, 0, 0};
  const Real determinant = after.determinant();
  const Real ratio = before.determinant() / determinant;
  if (!(ratio > floor)) return result;
  const Real d_ratio = d_factor / (2 * std::sqrt(ratio));
  add_determinant_gradient(before, d_ratio / determinant, result);
  add_determinant_gradient(after, -d_ratio * ratio / determinant, result);
  return result;
}

}  // namespace qs
