// SPDX-License-Identifier: MIT
#include "support/scenes.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "raster/kernel/constants.h"

namespace qs::test {

GaussianCloud random_cloud(std::size_t count, int sh_degree, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random);
  };
  std::normal_distribution<float> normal;
  GaussianCloud cloud;
  cloud.resize(count, sh_degree);
  for (std::size_t i = 0; i < count; ++i) {
    float z = uniform(0.5f, 8.0f);
    if (i % 17 == 0) z = 3.0f;                  // ties in depth
    if (i % 23 == 0) z = uniform(-1.0f, 0.3f);  // around and behind the near plane
    const float spread = i % 13 == 0 ? 3.0f : 0.8f;
    cloud.positions[i] = {uniform(-spread, spread) * std::abs(z),
                          uniform(-spread, spread) * std::abs(z), z};
    const float size = uniform(-6.0f, -2.0f);
    cloud.log_scales[i] = {size, size + uniform(-0.5f, 0.5f), size + uniform(-0.5f, 0.5f)};
    if (i % 3 == 0) cloud.log_scales[i].x += uniform(1.0f, 3.0f);  // needle
    if (i % 5 == 0) cloud.log_scales[i].z = -INFINITY;             // flat
    cloud.rotations[i] =
        glm::normalize(glm::quat(normal(random), normal(random), normal(random), normal(random)));
    cloud.opacity_logits[i] = uniform(-5.0f, 4.0f);
    if (i % 29 == 0) cloud.opacity_logits[i] = INFINITY;
    if (i % 31 == 0) cloud.opacity_logits[i] = -7.0f;  // below 1/255
    const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(sh_degree));
    for (std::size_t k = 0; k < coefficients; ++k) {
      const float range = k == 0 ? 1.7f : 0.3f;
      cloud.sh[i * coefficients + k] = {uniform(-range, range), uniform(-range, range),
                                        uniform(-range, range)};
    }
  }
  return cloud;
}

GaussianCloud surrounding_cloud(std::size_t count, int sh_degree, unsigned seed) {
  GaussianCloud cloud = random_cloud(count, sh_degree, seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> octave(std::log2(0.05f), std::log2(50.0f));
  std::normal_distribution<float> normal;
  for (glm::vec3& position : cloud.positions) {
    const glm::vec3 direction(normal(random), normal(random), normal(random));
    position = std::exp2(octave(random)) * glm::normalize(direction);
  }
  return cloud;
}

GaussianCloud scattered_cloud(std::size_t count, int side,
                              const std::function<double(std::size_t)>& depth) {
  std::mt19937 random(11);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const Camera camera = front_camera(side, side);
  GaussianCloud cloud;
  cloud.resize(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const double z = depth(i), px = z / camera.focal_px.x, middle = 0.5 * side;
    cloud.positions[i] = {(uniform(0, side) - middle) * px, (uniform(0, side) - middle) * px, z};
    const double size = i % 500 == 0 ? uniform(0.1, 1) * side : std::exp(uniform(-1, 2.5));
    for (int axis = 0; axis < 3; ++axis) {
      cloud.log_scales[i][axis] = static_cast<float>(std::log(size * px * uniform(0.2, 1)));
    }
    cloud.rotations[i] = glm::normalize(
        glm::quat(static_cast<float>(uniform(-1, 1)), static_cast<float>(uniform(-1, 1)),
                  static_cast<float>(uniform(-1, 1)), static_cast<float>(uniform(0.1, 1))));
    cloud.opacity_logits[i] = 1;
    cloud.sh[i] = glm::vec3(0.5f);
  }
  return cloud;
}

GaussianCloud single_gaussian(glm::vec3 position, float sigma, glm::vec3 color,
                              float opacity_logit) {
  GaussianCloud cloud;
  cloud.resize(1, 0);
  cloud.positions[0] = position;
  cloud.log_scales[0] = glm::vec3(std::log(sigma));
  cloud.rotations[0] = glm::quat(1, 0, 0, 0);
  cloud.opacity_logits[0] = opacity_logit;
  cloud.sh[0] = (color - 0.5f) / static_cast<float>(kSh0);
  return cloud;
}

void append(GaussianCloud& cloud, const GaussianCloud& more) {
  const auto add = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  add(cloud.positions, more.positions);
  add(cloud.log_scales, more.log_scales);
  add(cloud.rotations, more.rotations);
  add(cloud.opacity_logits, more.opacity_logits);
  add(cloud.sh, more.sh);
  cloud.sh_degree = more.sh_degree;
}

GaussianCloud with_storage_noise(GaussianCloud cloud, unsigned seed) {
  std::mt19937 random(seed);
  const auto half_of = [&](float step) {
    return std::uniform_real_distribution<float>(-0.5f * step, 0.5f * step)(random);
  };
  const auto add_to = [&](glm::vec3& values, float step) {
    values += glm::vec3(half_of(step), half_of(step), half_of(step));
  };
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    add_to(cloud.positions[i], 1.0f / 4096);
    add_to(cloud.log_scales[i], 1.0f / 16);
    const float opacity = 1 / (1 + std::exp(-cloud.opacity_logits[i]));
    const float noisy = std::clamp(opacity + half_of(1.0f / 255), 0.0f, 1.0f);
    cloud.opacity_logits[i] = std::log(noisy / (1 - noisy));
    for (std::size_t k = 0; k < coefficients; ++k) {
      add_to(cloud.sh[i * coefficients + k], k == 0  ? 1 / (255 * 0.15f)
                                             : k < 4 ? 1.0f / 16
                                                     : 1.0f / 8);
    }
  }
  return cloud;
}

Camera front_camera(int width, int height) {
  Camera camera;
  camera.focal_px = glm::dvec2(0.87 * width, 0.88 * width);
  camera.center_px = {0.5 * (width - 1), 0.5 * (height - 1)};
  camera.width = width;
  camera.height = height;
  return camera;
}

Camera with_projection(Camera camera, Projection projection, double depth) {
  camera.projection = projection;
  if (projection == Projection::orthographic) camera.focal_px /= depth;
  return camera;
}

}  // namespace qs::test
