// SPDX-License-Identifier: MIT
//
// A second implementation of 3DGS from the formulas, in double precision and without tiles. It
// shares no code with src/raster/kernel, so that a mistake there is detected. It is slow: every
// pixel tries every Gaussian.
#pragma once

#include <functional>

#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"
#include "raster/scene/image.h"

namespace qs::test {

struct OracleSettings {
  glm::dvec3 background{0.0};
  int sh_degree = 3;
  bool antialiased = false;
  double splat_scale = 1, dilation = 0.3;
  /// True if Gaussian i contributes to pixel (x, y); unset = every Gaussian contributes to every
  /// pixel.
  std::function<bool(std::size_t i, int x, int y)> acts;
};

/// height x width x 3.
Image oracle_image(const GaussianCloud& cloud, const Camera& camera,
                   const OracleSettings& settings = {});

/// Sigma = R diag(scale)^2 R^T of a unit quaternion and standard deviations.
glm::dmat3 covariance(const glm::dquat& rotation, const glm::dvec3& scale);
/// Covariance of Gaussian i in world axes.
glm::dmat3 covariance(const GaussianCloud& cloud, std::size_t i);

/// Sum of the SH functions of degrees 0..degree of Gaussian i towards the unit `direction`: RGB
/// without the 0.5 that colours add.
glm::dvec3 sh_sum(const GaussianCloud& cloud, std::size_t i, int degree, glm::dvec3 direction);

/// Real spherical harmonic Y_l^m with the Condon-Shortley sign, of a unit direction.
double spherical_harmonic(int l, int m, glm::dvec3 direction);

}  // namespace qs::test
