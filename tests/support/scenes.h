// SPDX-License-Identifier: MIT
//
// Small deterministic scenes and cameras for tests, with all difficult kinds of Gaussians.
#pragma once

#include <functional>

#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::test {

/// `count` Gaussians in front of the origin, looking along +z: round, needles, flat discs, faint,
/// opaque, some behind the camera, some far outside, several at equal depth.
GaussianCloud random_cloud(std::size_t count, int sh_degree, unsigned seed);

/// The same Gaussians on all sides of the origin, 0.05 to 50 units away, in random order.
GaussianCloud surrounding_cloud(std::size_t count, int sh_degree, unsigned seed);

/// `count` Gaussians in front of front_camera(side, side), all over the picture, most of them a few
/// pixels large, a few as large as the picture; gray, of opacity logit 1. depth(i) is the distance
/// of Gaussian i.
GaussianCloud scattered_cloud(std::size_t count, int side,
                              const std::function<double(std::size_t)>& depth);

/// One opaque round Gaussian of RGB `color` at `position` with standard deviation `sigma`.
GaussianCloud single_gaussian(glm::vec3 position, float sigma, glm::vec3 color,
                              float opacity_logit);

/// Appends the Gaussians of `more`. Both have the same SH degree.
void append(GaussianCloud& cloud, const GaussianCloud& more);

/// The cloud with seeded noise of up to half a step of .spz storage in position (2^-12), log scale
/// (1/16), opacity (1/255) and colour (DC 1/(255 * 0.15); SH 1/16 and 1/8), so that values which
/// were stored in 8 bits are between the steps.
GaussianCloud with_storage_noise(GaussianCloud cloud, unsigned seed);

/// A camera at the origin looking along +z, horizontal field of view about 60 degrees.
Camera front_camera(int width, int height);

/// The camera with another projection; an orthographic one shows as much as before at `depth`.
Camera with_projection(Camera camera, Projection projection, double depth = 5);

inline constexpr Projection kOtherProjections[] = {Projection::face, Projection::orthographic};

}  // namespace qs::test
