// SPDX-License-Identifier: MIT
#include "app/framing/fit_view.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace qs {
namespace {

constexpr std::size_t kMostPoints = 400;
constexpr double kFilled = 0.72, kLeastFilled = 0.5;  ///< share of the height that the box fills
constexpr double kLeastDense = 0.47;  ///< share that the middle 90 % of the points fill
constexpr double kShown = 0.95;       ///< the middle 98 % fill at most this share
constexpr double kMostOff = 0.06;     ///< largest offset of the box's middle, in heights
constexpr double kLine = 4;           ///< a shape so much wider than high shows its whole width

/// A rectangle in the picture, in heights of the picture from its centre.
struct Rectangle {
  glm::dvec2 low{1e9}, high{-1e9};
  glm::dvec2 center() const { return 0.5 * (low + high); }
  double height() const { return std::max(high.y - low.y, 1e-3); }  // flat shapes seen edge-on
};

/// The extents of a shape in the picture.
struct ScreenExtents {
  Rectangle box;            ///< its corners
  Rectangle dense, nearly;  ///< the middle 90 % and 98 % of its points
};

/// The eye and axes from which fit_view() makes a camera.
struct Viewpoint {
  glm::dvec3 right, down, forward, eye;
  double nearest;  ///< smallest depth; nearer points and points behind the eye get it

  glm::dvec2 project(glm::dvec3 point) const {
    const glm::dvec3 from = point - eye;
    const double depth = std::max(glm::dot(from, forward), nearest);
    return glm::dvec2(glm::dot(from, right), glm::dot(from, down)) /
           (2 * std::tan(0.5 * kVerticalFov) * depth);
  }
};

ScreenExtents extents_of(const Shape& shape, const Viewpoint& viewpoint) {
  ScreenExtents extents;
  for (const glm::dvec3& corner : shape.corners) {
    const glm::dvec2 at = viewpoint.project(corner);
    extents.box.low = glm::min(extents.box.low, at);
    extents.box.high = glm::max(extents.box.high, at);
  }
  std::vector<double> values(shape.points.size());
  for (int axis = 0; axis < 2; ++axis) {
    std::transform(shape.points.begin(), shape.points.end(), values.begin(),
                   [&](glm::dvec3 point) { return viewpoint.project(point)[axis]; });
    const Quantiles quantiles(values, shape.weights);
    extents.dense.low[axis] = quantiles.at(0.05);
    extents.dense.high[axis] = quantiles.at(0.95);
    extents.nearly.low[axis] = quantiles.at(0.01);
    extents.nearly.high[axis] = quantiles.at(0.99);
  }
  return extents;
}

}  // namespace

Shape shape_of(const Subject& subject, double smallest) {
  Shape shape;
  shape.center = glm::dvec3(subject.box.center());
  glm::dvec3 half = 0.5 * glm::dvec3(subject.box.size());
  const bool tiny = !(std::max({half.x, half.y, half.z}) > smallest);
  if (tiny) half = glm::dvec3(smallest);
  shape.radius = glm::length(half);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 side(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    shape.corners.push_back(shape.center + side * half);
  }
  if (tiny) {
    shape.points = shape.corners;
    shape.weights.assign(shape.points.size(), 1.0f);
    return shape;
  }
  const std::size_t count = std::min(subject.positions.size(), kMostPoints);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k * subject.positions.size() / count;
    shape.points.emplace_back(subject.positions[i]);
    shape.weights.push_back(subject.weights[i]);
  }
  return shape;
}

Framing fit_view(const Shape& shape, glm::dvec3 toward_eye, glm::dvec3 up) {
  constexpr int kRounds = 8;  // the height is nearly proportional to 1 / distance
  const glm::dvec3 right = glm::normalize(glm::cross(-toward_eye, up));
  const glm::dvec3 down = glm::cross(-toward_eye, right);
  glm::dvec3 target = shape.center;
  double distance = 3 * shape.radius;
  ScreenExtents extents;
  for (int round = 0; round <= kRounds; ++round) {
    extents = extents_of(
        shape, {right, down, -toward_eye, target + distance * toward_eye, 0.05 * shape.radius});
    if (round == kRounds) break;
    // Move the target to the middle of the shape on the screen.
    const glm::dvec2 box = extents.box.center();
    const glm::dvec2 center = box + glm::clamp(extents.nearly.center() - box, glm::dvec2(-kMostOff),
                                               glm::dvec2(kMostOff));
    const double height = 2 * distance * std::tan(0.5 * kVerticalFov);
    target += height * (center.x * right + center.y * down);
    // Change the distance so that the shape fills the wanted part of the screen.
    const double smallest =
        std::max(kLeastFilled / extents.box.height(),
                 std::min(kLeastDense / extents.dense.height(), kFilled / extents.box.height()));
    const double factor = std::max(
        smallest, std::min(kFilled / extents.box.height(), kShown / extents.nearly.height()));
    distance = std::max(distance / std::clamp(factor, 0.5, 2.0), 0.7 * shape.radius);
  }
  Framing framing;
  framing.eye = target + distance * toward_eye;
  framing.target = target;
  framing.up = up;
  framing.vertical_fov = kVerticalFov;
  framing.aspect = 2 * std::max(-extents.box.low.x, extents.box.high.x) / kShown;
  framing.farthest =
      framing.aspect > kLine ? framing.aspect : std::max(1.0, extents.box.height() / kLeastFilled);
  framing.near_depth = std::min(0.2, 0.01 * distance);
  return framing;
}

}  // namespace qs
