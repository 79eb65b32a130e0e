// SPDX-License-Identifier: MIT
//
// Activation: covariances and opacities from a cloud's logarithms, rotations and logits. It runs on
// the host in double precision, so that every backend starts from the same bits.
#pragma once

#include "base/parallel.h"
#include "raster/kernel/footprint.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

struct Activated {
  ActiveGaussian gaussian;
  float opacity;  ///< 0..1
};

/// Rounds a Gaussian's values, computed in double precision, to the precision that renderers read.
Activated activate(glm::vec3 position, const Covariance3<double>& covariance, double opacity);

Activated activate(const GaussianCloud& cloud, std::size_t i);

/// All Gaussians of a cloud, in its order.
struct ActivatedCloud {
  Array<ActiveGaussian> gaussians;
  Array<float> opacities;  ///< 0..1
};

ActivatedCloud activate(const GaussianCloud& cloud, ThreadPool& pool);

/// Covariance R diag(s^2) R^T of Gaussian `i`, world units^2.
Covariance3<double> world_covariance(const GaussianCloud& cloud, std::size_t i);

/// 1 / (1 + e^-logit); +-inf give 1 and 0.
double opacity_of_logit(float logit);

}  // namespace qs
