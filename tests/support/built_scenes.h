// SPDX-License-Identifier: MIT
//
// Scenes built of surfaces: flat opaque Gaussians in floors, walls and balls.
#pragma once

#include <cmath>
#include <optional>
#include <random>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>

#include "raster/scene/gaussian_cloud.h"

namespace qs::test {

struct SceneBuilder {
  explicit SceneBuilder(unsigned seed) : random(seed) {}

  GaussianCloud cloud;
  std::mt19937 random;
  std::optional<glm::vec3> paint;  ///< the colour of new pieces, about; unset: any

  /// A flat Gaussian of standard deviation `sigma` that lies in a surface with this normal, which
  /// is off by about 3 degrees.
  void piece(glm::vec3 position, glm::vec3 normal, float sigma, glm::vec3 color) {
    std::normal_distribution<float> noise(0, 0.04f);
    const glm::vec3 to =
        glm::normalize(normal + glm::vec3(noise(random), noise(random), noise(random)));
    const glm::vec3 from(0, 0, 1);
    const glm::vec3 axis = glm::cross(from, to);
    const float sine = glm::length(axis);
    cloud.positions.push_back(position);
    cloud.rotations.push_back(sine > 1e-6f ? glm::angleAxis(std::atan2(sine, to.z), axis / sine)
                                           : glm::quat(1, 0, 0, 0));
    cloud.log_scales.push_back(
        glm::vec3(std::log(sigma), std::log(1.5f * sigma), std::log(0.05f * sigma)));
    cloud.opacity_logits.push_back(4);
    cloud.sh.push_back((color - 0.5f) / 0.28209479f);
  }

  glm::vec3 some_color() {
    std::uniform_real_distribution<float> value(0.1f, 0.9f);
    if (paint) return *paint + 0.2f * (value(random) - 0.5f);
    return {value(random), value(random), value(random)};
  }

  /// `a` and `b` reach from the middle to the sides.
  void rectangle(int count, glm::vec3 middle, glm::vec3 a, glm::vec3 b) {
    std::uniform_real_distribution<float> at(-1, 1);
    const glm::vec3 normal = glm::normalize(glm::cross(a, b));
    const float sigma = std::sqrt(glm::length(a) * glm::length(b) / static_cast<float>(count));
    for (int i = 0; i < count; ++i) {
      const float x = at(random), y = at(random);
      piece(middle + x * a + y * b, normal, sigma, some_color());
    }
  }

  /// The surface of a box.
  void box(int count, glm::vec3 middle, glm::vec3 half) {
    const float areas = half.x * half.y + half.y * half.z + half.z * half.x;
    for (int axis = 0; axis < 3; ++axis) {
      glm::vec3 a(0), b(0), out(0);
      a[(axis + 1) % 3] = half[(axis + 1) % 3];
      b[(axis + 2) % 3] = half[(axis + 2) % 3];
      out[axis] = half[axis];
      const float share = glm::length(a) * glm::length(b) / areas;
      for (const float side : {-1.0f, 1.0f})
        rectangle(static_cast<int>(0.5f * share * static_cast<float>(count)), middle + side * out,
                  a, b);
    }
  }

  void disc(int count, glm::vec3 middle, glm::vec3 normal, float radius) {
    const glm::vec3 other = std::abs(normal.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1);
    const glm::vec3 x = glm::normalize(glm::cross(normal, other)), y = glm::cross(normal, x);
    std::uniform_real_distribution<float> share(0, 1);
    for (int i = 0; i < count; ++i) {
      const float angle = 2 * glm::pi<float>() * share(random);
      const float from = radius * std::sqrt(share(random));
      piece(middle + from * (std::cos(angle) * x + std::sin(angle) * y), normal,
            radius / std::sqrt(static_cast<float>(count)), some_color());
    }
  }

  void ball(int count, glm::vec3 middle, float radius) {
    std::normal_distribution<float> normal;
    for (int i = 0; i < count; ++i) {
      const glm::vec3 out =
          glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
      piece(middle + radius * out, out, 2 * radius / std::sqrt(static_cast<float>(count)),
            some_color());
    }
  }

  /// Balls in a ring around the origin, which touch the plane y = 0.
  void trees(int count, float distance, float radius) {
    for (int i = 0; i < count; ++i) {
      const float angle = 2 * glm::pi<float>() * static_cast<float>(i) / static_cast<float>(count);
      ball(800, {distance * std::cos(angle), -radius, distance * std::sin(angle)}, radius);
    }
  }

  /// Four walls and a floor at y = 0, and a ceiling if `closed`. They are bare: few large
  /// Gaussians.
  void room(glm::vec3 half, bool closed) {
    const auto bare = [&](glm::vec3 middle, glm::vec3 a, glm::vec3 b) {
      rectangle(static_cast<int>(200 * glm::length(a) * glm::length(b)), middle, a, b);
    };
    const glm::vec3 x(half.x, 0, 0), y(0, half.y, 0), z(0, 0, half.z);
    paint = glm::vec3(0.45f, 0.3f, 0.2f);
    bare({0, 0, 0}, x, z);
    paint = glm::vec3(0.8f);
    if (closed) bare(-2.0f * y, x, z);
    for (const float side : {-1.0f, 1.0f}) {
      bare(side * x - y, y, z);
      bare(side * z - y, y, x);
    }
    paint.reset();
  }

  /// Large faint Gaussians at random places up to `reach` away.
  void floaters(int count, glm::vec3 middle, float reach, float sigma) {
    std::uniform_real_distribution<float> at(-1, 1);
    for (int i = 0; i < count; ++i) {
      const glm::vec3 normal(at(random), at(random), 1.1f);
      piece(middle + reach * glm::vec3(at(random), at(random), at(random)), normal, sigma,
            some_color());
      cloud.opacity_logits.back() = -1;
    }
  }

  /// Turns the scene around the origin.
  void turn(glm::quat rotation) {
    for (glm::vec3& p : cloud.positions) p = rotation * p;
    for (glm::quat& q : cloud.rotations) q = rotation * q;
  }
};

}  // namespace qs::test
