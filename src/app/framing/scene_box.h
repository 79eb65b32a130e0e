// SPDX-License-Identifier: MIT
//
// The extents of a scene: the box of all centres, the core box without outliers, and the view of a
// whole box: upright, slightly from above, as large as fits. The camera is oriented to the world's
// up direction; the scene is not rotated. first_view.h chooses better views of a scene; grids of
// growing size are compared in this view.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/rank.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

struct Scene;

/// The vertical field of view of the cameras that framings make.
inline constexpr double kVerticalFov = glm::radians(60.0);

inline float largest_of(const glm::vec3& v) { return std::max({v.x, v.y, v.z}); }

/// An axis-aligned box, world units; low <= high.
struct SceneBox {
  glm::vec3 low{0.0f}, high{0.0f};
  glm::vec3 center() const { return 0.5f * (low + high); }
  glm::vec3 size() const { return high - low; }
};

/// Per axis, from the `low` to the `high` quantile (0..1) of the centres. (0, 1) covers all
/// centres. An empty cloud gives a box of size 0 at the origin.
SceneBox scene_box(const GaussianCloud& cloud, double low = 0, double high = 1);

/// The box without the outermost 5 % of the centres at each end of each axis. It determines the
/// view and the speed of movements.
inline SceneBox core_box(const GaussianCloud& cloud) { return scene_box(cloud, 0.05, 0.95); }

/// A camera that shows the whole box at width x height with a vertical field of view of 60 degrees.
/// `smallest` is the least radius to show, because a box may have size 0. The near plane is at
/// min(0.2, 0.01 x the box's longest side).
Camera frame_box(const SceneBox& box, float smallest, glm::dvec3 up, int width, int height);

/// The least radius that frame_box() should show of this scene: three standard deviations of the
/// median Gaussian, so that a scene with one Gaussian is framed too. World units, > 0.
float smallest_framing(const GaussianCloud& cloud);

/// frame_box() of the scene's core extents.
Camera frame_cloud(const GaussianCloud& cloud, glm::dvec3 up, int width, int height);

// A failed training leaves Gaussians that are larger than their scene, and a single one can cover
// every picture.

/// The standard deviation above which a Gaussian is larger than the scene, world units, > 0: the
/// diagonal of core_box(), but at least smallest_framing().
float scene_length(const SceneBox& core, float smallest);
float scene_length(const GaussianCloud& cloud);

/// Gaussians whose longest standard deviation is above `length`, a scene_length().
std::size_t count_huge(const GaussianCloud& cloud, float length);
inline std::size_t count_huge(const GaussianCloud& cloud) {
  return count_huge(cloud, scene_length(cloud));
}

/// Removes Gaussians above scene_length() and returns their number. For a scene this is a step of
/// its edits.
std::size_t drop_huge(GaussianCloud& cloud);
std::size_t drop_huge(Scene& scene);

/// "3 Gaussians are larger than the scene", with the right form for 1.
std::string huge_text(std::size_t count);

}  // namespace qs
