// SPDX-License-Identifier: MIT
//
// The surfaces of a scene in a picture, which hide the nodes behind them.
#pragma once

#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/camera.h"

namespace qs {

class LodSurfaces {
 public:
  /// `depths`: DepthMaps::median of a picture of this pinhole camera. `margin`: pixels
  /// around a ball that count as its own, because a view a little beside shows the ball there.
  LodSurfaces(const Camera& camera, std::vector<float> depths, float margin = 0);

  /// The share of a ball's pixels whose surface is not in front of the whole ball, kLeastSeen to 1.
  /// At most 8 x 8 of its pixels are looked up. 1 for a ball outside of the picture or around the
  /// camera.
  float share_seen(const glm::vec3& center, float radius) const;

  /// The median of the depths; infinite if most pixels have no surface.
  float distance() const { return distance_; }

  /// Surfaces are known roughly, so nodes behind them count a little.
  static constexpr float kLeastSeen = 0.01f;

 private:
  glm::mat3 turn_;  // of the world's axes
  glm::dvec3 eye_;
  glm::vec2 focal_, center_;
  int width_, height_;
  float margin_, near_depth_, distance_;
  std::vector<float> depths_;  // infinite where nothing hides
};

}  // namespace qs
