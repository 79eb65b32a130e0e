// SPDX-License-Identifier: MIT
//
// Distances, angles and heights of points on surfaces, with the scale and the ground that a user
// gives.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "raster/select/surface.h"

namespace qs {

/// A plane, whose points have the height 0.
struct GroundPlane {
  glm::dvec3 point{0.0};    ///< as the cloud's positions count
  glm::dvec3 up{0, -1, 0};  ///< a unit vector
  bool operator==(const GroundPlane&) const = default;
};

/// The plane through three points, with the eye above it. A normal within 3 degrees of an axis is
/// that axis. Empty if the points are on a line.
std::optional<GroundPlane> ground_through(std::span<const SurfacePoint, 3> points);

/// The standard error of the tilt of that plane, degrees; large if they are nearly on a line.
double degrees_of_tilt_error(std::span<const SurfacePoint, 3> points);

/// The turn that makes `up` the up of a level scene, -y.
glm::dquat level_turn(glm::dvec3 up);

/// The meaning of the scene's units; values of the scene stay as they are.
struct MeasureScale {
  double factor = 1;      ///< of the unit for a world unit, > 0
  double error = 0;       ///< of the factor, relative
  std::string unit = {};  ///< empty: lengths are in world units

  std::string name() const { return unit.empty() ? "units" : unit; }
  bool operator==(const MeasureScale&) const = default;
};

inline constexpr const char* kLengthUnits[] = {"m", "cm", "mm", "ft", "in"};

/// The points that were measured in a scene, and their meaning.
struct Measures {
  std::vector<std::vector<SurfacePoint>> lines = {{}};  ///< polylines; the last one grows
  MeasureScale scale = {};
  std::optional<GroundPlane> ground = {};

  std::size_t points() const {
    std::size_t count = 0;
    for (const auto& line : lines) count += line.size();
    return count;
  }
  bool operator==(const Measures&) const = default;
};

/// The scale that makes the distance of two points this length > 0. Empty if they are the same.
std::optional<MeasureScale> scale_of(const SurfacePoint& from, const SurfacePoint& to, double known,
                                     std::string unit);

/// From a point to the next point, in the unit of the scale.
struct MeasuredLeg {
  MeasuredLength length;
  glm::dvec3 offset{0.0};
};
MeasuredLeg measured_leg(const SurfacePoint& from, const SurfacePoint& to,
                         const MeasureScale& scale);

/// The angle at b between the directions to a and c, degrees.
double degrees_at(const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c);

/// "1 to 2", "5.31 ± 0.02 m", "x 5, y 0.2, z 1; height 0.2".
struct MeasureRow {
  std::string name, value, more = {};
};

/// "5.31 ± 0.02 m"
std::string length_text(double length, double error, const std::string& unit);

/// The rows of a polyline: its distances, their sum if there are several, and its angles. `first`:
/// the number of its first point. `up`: for heights.
std::vector<MeasureRow> measure_rows(std::span<const SurfacePoint> line, std::size_t first,
                                     const MeasureScale& scale,
                                     const std::optional<glm::dvec3>& up);

}  // namespace qs
