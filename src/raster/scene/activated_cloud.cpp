// SPDX-License-Identifier: MIT
#include "raster/scene/activated_cloud.h"

#include <cmath>

#include <glm/gtc/quaternion.hpp>

#include "raster/kernel/activation.h"

namespace qs {

double opacity_of_logit(float logit) { return opacity_of(static_cast<double>(logit)); }

Covariance3<double> world_covariance(const GaussianCloud& cloud, std::size_t i) {
  return covariance_of(glm::dvec3(cloud.log_scales[i]), glm::dquat(cloud.rotations[i]));
}

Activated activate(glm::vec3 position, const Covariance3<double>& c, double opacity) {
  return {active_gaussian(position, c, opacity), static_cast<float>(opacity)};
}

Activated activate(const GaussianCloud& cloud, std::size_t i) {
  return activate(cloud.positions[i], world_covariance(cloud, i),
                  opacity_of_logit(cloud.opacity_logits[i]));
}

ActivatedCloud activate(const GaussianCloud& cloud, ThreadPool& pool) {
  ActivatedCloud active;
  active.gaussians.resize(cloud.size());
  active.opacities.resize(cloud.size());
  pool.for_each(cloud.size(), 4096, [&](std::size_t i) {
    const Activated activated = activate(cloud, i);
    active.gaussians[i] = activated.gaussian;
    active.opacities[i] = activated.opacity;
  });
  return active;
}

}  // namespace qs
