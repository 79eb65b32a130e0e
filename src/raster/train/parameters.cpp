// SPDX-License-Identifier: MIT
#include "raster/train/parameters.h"

#include <algorithm>

#include "raster/kernel/gradient/activation.h"

namespace qs::train {

GaussianCloud to_cloud(const Parameters& parameters, bool antialiased) {
  GaussianCloud cloud;
  cloud.resize(parameters.size(), parameters.sh_degree);
  cloud.antialiased = antialiased;
  std::copy(parameters.means.begin(), parameters.means.end(), cloud.positions.begin());
  std::copy(parameters.log_scales.begin(), parameters.log_scales.end(), cloud.log_scales.begin());
  std::copy(parameters.opacity_logits.begin(), parameters.opacity_logits.end(),
            cloud.opacity_logits.begin());
  std::copy(parameters.sh.begin(), parameters.sh.end(), cloud.sh.begin());
  std::transform(parameters.rotations.begin(), parameters.rotations.end(), cloud.rotations.begin(),
                 [](const glm::quat& q) { return glm::quat(unit_rotation(glm::dquat(q))); });
  return cloud;
}

Parameters from_cloud(const GaussianCloud& cloud) {
  Parameters parameters;
  parameters.sh_degree = cloud.sh_degree;
  parameters.means.assign(cloud.positions.begin(), cloud.positions.end());
  parameters.log_scales.assign(cloud.log_scales.begin(), cloud.log_scales.end());
  parameters.rotations.assign(cloud.rotations.begin(), cloud.rotations.end());
  parameters.opacity_logits.assign(cloud.opacity_logits.begin(), cloud.opacity_logits.end());
  parameters.sh.assign(cloud.sh.begin(), cloud.sh.end());
  return parameters;
}

}  // namespace qs::train
