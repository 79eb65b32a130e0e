// SPDX-License-Identifier: MIT
//
// Builds the clouds and cameras of the conformance kit.
#pragma once

#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "app/conformance/kit_scenes.h"

namespace qs {

inline constexpr int kKitWidth = 64, kKitHeight = 48;
inline constexpr double kKitFocal = 60;  ///< px

/// One Gaussian in convenient units.
struct Blob {
  glm::vec3 position{0, 0, 3};
  glm::vec3 sigma{0.2f};  ///< standard deviations, world units
  glm::vec3 color{1};     ///< colour without view dependence; may exceed 0..1
  float opacity = 0.9f;
  glm::quat rotation{1, 0, 0, 0};
};

/// A cloud with SH of degree `degree`; coefficients above the first are 0.
GaussianCloud cloud_of(const std::vector<Blob>& blobs, int degree = 0);

/// The coefficients of Gaussian `i`.
glm::vec3* sh_of(GaussianCloud& cloud, std::size_t i);

/// A camera at the origin that looks along +z.
Camera kit_camera(int width = kKitWidth, int height = kKitHeight,
                  glm::dvec2 focal_px = glm::dvec2(kKitFocal));

/// Rotation of a Gaussian about an axis by degrees.
glm::quat turned(glm::vec3 axis, float degrees);

/// The point that camera `camera` shows at a pixel, at view depth z.
glm::vec3 world_point(const Camera& camera, glm::dvec2 pixel, double z);

}  // namespace qs
