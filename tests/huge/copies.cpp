// SPDX-License-Identifier: MIT
#include "huge/copies.h"

#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "app/framing/scene_box.h"

namespace qs {

Copies scatter_copies(const GaussianCloud& scene, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  const SceneBox core = core_box(scene);
  const double size = std::max(1e-3, static_cast<double>(glm::length(core.size())));
  const double step = 1.2 * size;
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  Copies copies;
  for (std::size_t i = 0; i < count; ++i) {
    Instance& copy = copies.instances.emplace_back();
    const double turn = between(0, 2 * std::numbers::pi), tilt = between(0, 10);
    const double tilt_axis = between(0, 2 * std::numbers::pi);
    copy.rotation = glm::angleAxis(glm::radians(tilt),
                                   glm::dvec3(std::cos(tilt_axis), 0, std::sin(tilt_axis))) *
                    glm::angleAxis(turn, glm::dvec3(0, 1, 0));
    copy.scale = between(0.7, 1.3);
    for (int channel = 0; channel < 3; ++channel)
      copy.tint[channel] = static_cast<float>(between(0.7, 1.2));
    const glm::dvec3 place(step * static_cast<double>(i % columns), 0,
                           step * static_cast<double>(i / columns));
    copy.position = place - copy.scale * (copy.rotation * glm::dvec3(core.center()));
  }
  const double far = step * static_cast<double>(columns - 1);
  const auto look = [&](const char* name, const glm::dvec3& from, const glm::dvec3& to) {
    Camera camera = look_at(from, to, {0, -1, 0}, glm::radians(50.0), 800, 600);
    camera.name = name;
    camera.near_depth = std::min(0.2, 0.01 * size);
    copies.cameras.push_back(camera);
  };
  look("copy", {0, -0.2 * size, -1.2 * size}, {0, 0, 0});
  look("row", {-0.4 * size, -0.5 * size, -1.5 * size}, {0.5 * far, 0, far + size});
  look("above", {-size, -0.4 * far - 2 * size, -size}, {0.5 * far, 0, 0.5 * far});
  return copies;
}

}  // namespace qs
