// SPDX-License-Identifier: MIT
#include "app/conformance/kit_builder.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/trigonometric.hpp>

namespace qs {

GaussianCloud cloud_of(const std::vector<Blob>& blobs, int degree) {
  GaussianCloud cloud;
  cloud.resize(blobs.size(), degree);
  std::fill(cloud.sh.begin(), cloud.sh.end(), glm::vec3(0));
  for (std::size_t i = 0; i < blobs.size(); ++i) {
    const Blob& blob = blobs[i];
    cloud.positions[i] = blob.position;
    cloud.log_scales[i] = glm::log(blob.sigma);
    cloud.rotations[i] = blob.rotation;
    const double opacity = blob.opacity;
    cloud.opacity_logits[i] = static_cast<float>(std::log(opacity / (1 - opacity)));
    *sh_of(cloud, i) = (blob.color - 0.5f) / static_cast<float>(kSh0);
  }
  return cloud;
}

glm::vec3* sh_of(GaussianCloud& cloud, std::size_t i) {
  return cloud.sh.data() + i * static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
}

Camera kit_camera(int width, int height, glm::dvec2 focal_px) {
  Camera camera;
  camera.focal_px = focal_px;
  camera.center_px = 0.5 * glm::dvec2(width - 1, height - 1);
  camera.width = width;
  camera.height = height;
  return camera;
}

glm::quat turned(glm::vec3 axis, float degrees) {
  return glm::angleAxis(glm::radians(degrees), glm::normalize(axis));
}

glm::vec3 world_point(const Camera& camera, glm::dvec2 pixel, double z) {
  const glm::dvec2 slope = (pixel - camera.center_px) / camera.focal_px;
  const glm::dvec3 view(slope.x * z, slope.y * z, z);
  const glm::dmat3 rotation(camera.view_from_world);
  return glm::vec3(camera.position() + glm::transpose(rotation) * view);
}

}  // namespace qs
