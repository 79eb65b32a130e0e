// SPDX-License-Identifier: MIT
#include "raster/scene/activated_cloud.h"

#include <cmath>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

namespace qs {

double opacity_of_logit(float logit) { return 1 / (1 + std::exp(-static_cast<double>(logit))); }

Covariance3<double> world_covariance(const GaussianCloud& cloud, std::size_t i) {
  const glm::dvec3 log_scale(cloud.log_scales[i]);
  const glm::dvec3 scale(std::exp(log_scale.x), std::exp(log_scale.y), std::exp(log_scale.z));
  const glm::dmat3 r = glm::mat3_cast(glm::dquat(cloud.rotations[i]));
  const glm::dvec3 x = r[0] * scale.x, y = r[1] * scale.y, z = r[2] * scale.z;  // columns of R S
  return {x.x * x.x + y.x * y.x + z.x * z.x, x.x * x.y + y.x * y.y + z.x * z.y,
          x.x * x.z + y.x * y.z + z.x * z.z, x.y * x.y + y.y * y.y + z.y * z.y,
          x.y * x.z + y.y * y.z + z.y * z.z, x.z * x.z + y.z * y.z + z.z * z.z};
}

Activated activate(const GaussianCloud& cloud, std::size_t i) {
  const Covariance3<double> c = world_covariance(cloud, i);
  const double opacity = opacity_of_logit(cloud.opacity_logits[i]);
  return {{cloud.positions[i],
           {static_cast<float>(c.xx), static_cast<float>(c.xy), static_cast<float>(c.xz),
            static_cast<float>(c.yy), static_cast<float>(c.yz), static_cast<float>(c.zz)},
           static_cast<float>(std::log2(255 * opacity))},
          static_cast<float>(opacity)};
}

ActivatedCloud activate(const GaussianCloud& cloud, ThreadPool& pool) {
  ActivatedCloud active;
  active.gaussians.resize(cloud.size());
  active.opacities.resize(cloud.size());
  pool.for_chunks(cloud.size(), 4096, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const Activated activated = activate(cloud, i);
      active.gaussians[i] = activated.gaussian;
      active.opacities[i] = activated.opacity;
    }
  });
  return active;
}

}  // namespace qs
