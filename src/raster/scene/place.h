// SPDX-License-Identifier: MIT
//
// Georeferenced data: coordinates far from 0, such as UTM metres, whose steps in single precision
// are as large as Gaussians. Positions are moved by an origin, a round number near the middle of
// the data, while they are double; see GaussianCloud::origin. Data near 0 stays where it is.
// Cameras far away from all others.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The origin for `count` positions: their median, rounded to multiples of a power of ten of about
/// their size. 0 unless the median is more than 1,000 units from 0 and more than 16 times the size
/// of their middle 90 %.
glm::dvec3 origin_of(std::size_t count, const std::function<glm::dvec3(std::size_t i)>& position);

/// Moves the cloud to the origin_of() its positions, and adds that to cloud.origin. Differences of
/// floats to a round number near them are exact.
void move_near_origin(GaussianCloud& cloud);

/// Counts the positions from another origin.
void place(GaussianCloud& cloud, const glm::dvec3& origin);

/// "500000 4650000 200", and back. Unset: the text is not three finite numbers.
std::string format_origin(const glm::dvec3& origin);
std::optional<glm::dvec3> parse_origin(std::string_view text);

/// The cameras that are 10 times as far from the median place as half of the cameras are, by index.
/// Structure from motion placed them wrong. Empty if they are more than one and more than a
/// quarter.
std::vector<std::size_t> outliers(const std::vector<Camera>& cameras);

/// The cameras without outliers().
std::vector<Camera> without_outliers(const std::vector<Camera>& cameras);

/// True if the camera's picture shows a part of one of `count` balls: their centres, and their
/// radii as w. Looks at most at some thousand of them, at equal distances in their order.
bool sees_any(const Camera& camera, std::size_t count,
              const std::function<glm::dvec4(std::size_t i)>& ball);

}  // namespace qs
