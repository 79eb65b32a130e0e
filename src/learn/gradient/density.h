// SPDX-License-Identifier: MIT
//
// The terms per Gaussian of the strategies that change the number of Gaussians, as both backends
// compute them: the statistics of adaptive density control, and the terms that strategy mcmc
// (Kheradmand et al. 2024, arXiv 2404.09591) adds to a step of Adam. Low opacities and scales have
// a share in the loss, and noise moves nearly transparent Gaussians.
#pragma once

#include <cmath>

#include <glm/vec2.hpp>

#include "learn/gradient/activation.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/hd.h"
#include "raster/kernel/random.h"

namespace qs {

/// Adds the length of the loss's gradient by a Gaussian's position on the image, |dL/d mean| of a
/// view, or its absolute sums, see BackwardOrder, in normalised device
/// coordinates, where the image is 2 wide and 2 high. `half_px` is half the image's size in pixels;
/// `sum` is the Gaussian's sum over the views before. A gradient that is not finite adds nothing.
QS_HD void add_movement(const glm::vec2& half_px, const glm::vec2& d_mean_px, float& sum) {
  const glm::vec2 ndc = half_px * d_mean_px;
  const float norm = std::sqrt(ndc.x * ndc.x + ndc.y * ndc.y);
  if (norm - norm == 0.0f) sum += norm;
}

inline constexpr double kDeadOpacity = 0.005;  ///< nearly transparent, up to here

/// Adds opacity_weight mean(opacity) + scale_weight mean(scale) to the loss; the means are over
/// all Gaussians, and over the three axes.
struct Sparsity {
  double opacity_weight = 0, scale_weight = 0;

  /// Adds this term's derivatives for one of `count` > 0 Gaussians.
  QS_HD void add_gradient(double count, const glm::vec3& log_scale, float opacity_logit,
                          glm::vec3& d_log_scale, float& d_opacity_logit) const {
    const double opacity = opacity_of(static_cast<double>(opacity_logit));
    d_opacity_logit += static_cast<float>(opacity_gradient(opacity, opacity_weight / count));
    const double share = scale_weight / (3 * count);
    d_log_scale +=
        glm::vec3(static_cast<float>(std::exp(static_cast<double>(log_scale.x)) * share),
                  static_cast<float>(std::exp(static_cast<double>(log_scale.y)) * share),
                  static_cast<float>(std::exp(static_cast<double>(log_scale.z)) * share));
  }
};

/// The noise of MCMC: a normal vector times the covariance, `size` and a sigmoid that is 1 for
/// transparent Gaussians and falls at the opacity `middle`.
struct NoiseShape {
  double size = 0, slope = 100, middle = kDeadOpacity;

  /// The mean of a Gaussian after the noise of a standard normal vector. A noise that is not finite
  /// changes nothing.
  QS_HD glm::vec3 moved(const glm::vec3& mean, const glm::vec3& log_scale,
                        const glm::quat& rotation, float opacity_logit, const glm::dvec3& n) const {
    const double opacity = opacity_of(static_cast<double>(opacity_logit));
    const double factor = size * opacity_of(-slope * (opacity - middle));
    const Covariance3<double> c =
        covariance_of(glm::dvec3(log_scale), unit_rotation(glm::dquat(rotation)));
    const glm::vec3 offset(factor * glm::dvec3(c.xx * n.x + c.xy * n.y + c.xz * n.z,
                                               c.xy * n.x + c.yy * n.y + c.yz * n.z,
                                               c.xz * n.x + c.yz * n.y + c.zz * n.z));
    const glm::vec3 result = mean + offset;
    const float sum = result.x + result.y + result.z;
    return sum - sum == 0.0f ? result : mean;  // finite
  }
};

/// Standard normal vectors for that noise.
struct Noise {
  NoiseShape shape;
  Random random;

  /// The mean of Gaussian i after the noise.
  QS_HD glm::vec3 moved(std::uint64_t i, const glm::vec3& mean, const glm::vec3& log_scale,
                        const glm::quat& rotation, float opacity_logit) const {
    return shape.moved(mean, log_scale, rotation, opacity_logit, random.normal3(i));
  }
};

}  // namespace qs
