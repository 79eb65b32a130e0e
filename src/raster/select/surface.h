// SPDX-License-Identifier: MIT
//
// The point of the surface that a pixel shows, with its uncertainty, and distances between such
// points. A Gaussian stops a ray at the place where it is densest on it. Its centre would be off by
// several of its standard deviations on a surface that is seen at an angle.
#pragma once

#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/api/renderer.h"

namespace qs {

/// Lengths are in world units.
struct SurfacePoint {
  glm::dvec3 position{0.0};   ///< counts from the cloud's origin
  glm::dvec3 direction{0.0};  ///< of the ray from the eye, a unit vector
  double distance = 0;        ///< from the eye
  /// Standard deviation along the ray: of the Gaussian that stops the half, and half of the
  /// distance between the places where 1/4 and 3/4 of the light are stopped (the last Gaussian, if
  /// less are).
  double along = 0;
  double across = 0;           ///< standard deviation of a place in a pixel
  std::uint32_t gaussian = 0;  ///< that stops the half, an index of the cloud

  /// True if the surface is too soft for a distance.
  bool is_soft() const { return along > 0.05 * distance; }
  bool operator==(const SurfacePoint&) const = default;
};

/// A Gaussian on a ray: the distance at which it is densest, not below 0, and the standard
/// deviation of its density there, world units.
struct OnRay {
  double at = 0, sigma = 0;
};
/// `direction`: a unit vector; the eye counts as the cloud's positions do.
OnRay on_ray(const GaussianCloud& cloud, std::size_t i, glm::dvec3 eye, glm::dvec3 direction);

/// The point where half of the light of a pixel is stopped. Empty if less is stopped, or if the
/// pixel is outside of the picture. `frame`: of this cloud and camera, with a trace.
std::optional<SurfacePoint> surface_at(const Frame& frame, const GaussianCloud& cloud,
                                       const Camera& camera, glm::ivec2 pixel);

/// A line of sight.
struct Sight {
  glm::dvec3 eye{0.0}, direction{0, 0, 1};  ///< counts from the cloud's origin; a unit vector
  double across = 0;                        ///< SurfacePoint::across of a place at the distance 1
};
/// `camera`: its origin is the cloud's.
Sight sight_of(const Camera& camera, glm::dvec2 pixel);

/// The place where two lines of sight are nearest to each other, which is in their middle.
struct Crossing {
  SurfacePoint point;  ///< its uncertainty includes the gap; direction: the mean of both
  double gap = 0;      ///< between the lines
};
/// Empty if they are parallel, or nearest behind an eye.
std::optional<Crossing> crossing(const Sight& a, const Sight& b);
/// The line of sight from which a point was measured; it must have a distance.
Sight sight_of(const SurfacePoint& point);

struct MeasuredLength {
  double length = 0, error = 0;  ///< error: from both points' uncertainties
};
MeasuredLength length_between(const SurfacePoint& a, const SurfacePoint& b);

}  // namespace qs
