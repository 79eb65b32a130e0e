// SPDX-License-Identifier: MIT
#include "raster/select/measures.h"

#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtx/quaternion.hpp>

namespace qs {
namespace {

constexpr double kSnapDegrees = 3;  // of an axis

double degrees_between(glm::dvec3 a, glm::dvec3 b) {
  return glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

// 0 in place of a value that is nothing but rounding beside `size`.
double without_noise(double value, double size) {
  return std::abs(value) <= 1e-9 * size ? 0.0 : value;
}

}  // namespace

std::optional<GroundPlane> ground_through(std::span<const SurfacePoint, 3> points) {
  const glm::dvec3 to_second = points[1].position - points[0].position;
  const glm::dvec3 across = glm::cross(to_second, points[2].position - points[0].position);
  if (!(glm::length(across) > 1e-6 * glm::dot(to_second, to_second))) return std::nullopt;
  glm::dvec3 up = glm::normalize(across);
  if (glm::dot(up, points[0].direction) > 0) up = -up;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 exact(0.0);
    exact[axis] = std::copysign(1.0, up[axis]);
    if (degrees_between(up, exact) <= kSnapDegrees) up = exact;
  }
  return GroundPlane{points[0].position, up};
}

// A point that is off by h along the normal tilts the plane by h over its distance from the line of
// the two others. The errors of the points are independent.
double degrees_of_tilt_error(std::span<const SurfacePoint, 3> points) {
  double variance = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const SurfacePoint& point = points[i];
    const glm::dvec3 from = points[(i + 1) % 3].position, to = points[(i + 2) % 3].position;
    const glm::dvec3 across = glm::cross(to - from, point.position - from);
    const double cosine = glm::dot(point.direction, glm::normalize(across));
    const double distance = glm::length(across) / glm::distance(from, to);
    variance += (point.along * point.along * cosine * cosine +
                 point.across * point.across * (1 - cosine * cosine)) /
                (distance * distance);
  }
  return glm::degrees(std::sqrt(variance));
}

glm::dquat level_turn(glm::dvec3 up) { return glm::rotation(up, glm::dvec3(0, -1, 0)); }

std::optional<MeasureScale> scale_of(const SurfacePoint& from, const SurfacePoint& to, double known,
                                     std::string unit) {
  const MeasuredLength length = length_between(from, to);
  if (!(length.length > 0)) return std::nullopt;
  return MeasureScale{known / length.length, length.error / length.length, std::move(unit)};
}

MeasuredLeg measured_leg(const SurfacePoint& from, const SurfacePoint& to,
                         const MeasureScale& scale) {
  const MeasuredLength length = length_between(from, to);
  return {{scale.factor * length.length,
           scale.factor * std::hypot(length.error, scale.error * length.length)},
          scale.factor * (to.position - from.position)};
}

double degrees_at(const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) {
  return degrees_between(a.position - b.position, c.position - b.position);
}

std::string length_text(double length, double error, const std::string& unit) {
  return fmt::format("{:.5g} ± {:.2g} {}", without_noise(length, error), error, unit);
}

std::vector<MeasureRow> measure_rows(std::span<const SurfacePoint> line, std::size_t first,
                                     const MeasureScale& scale,
                                     const std::optional<glm::dvec3>& up) {
  std::vector<MeasureRow> rows;
  double total = 0, variance = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const auto [length, offset] = measured_leg(line[i], line[i + 1], scale);
    rows.push_back(
        {fmt::format("{} to {}", first + i, first + i + 1),
         length_text(length.length, length.error, scale.name()),
         fmt::format("x {:.4g}, y {:.4g}, z {:.4g}{}", offset.x, offset.y, offset.z,
                     up ? fmt::format("; height {:.4g}",
                                      without_noise(glm::dot(offset, *up), length.length))
                        : "")});
    total += length.length;
    variance += length.error * length.error;
  }
  if (line.size() > 2)
    rows.push_back({"together", length_text(total, std::sqrt(variance), scale.name())});
  for (std::size_t i = 1; i + 1 < line.size(); ++i)
    rows.push_back({fmt::format("angle at {}", first + i),
                    fmt::format("{:.2f} degrees", degrees_at(line[i - 1], line[i], line[i + 1]))});
  return rows;
}

}  // namespace qs
