// SPDX-License-Identifier: MIT
#include "raster/scene/camera.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "raster/kernel/constants.h"

namespace qs {

glm::dvec3 Camera::position() const {
  const glm::dmat3 rotation(view_from_world);
  return -glm::transpose(rotation) * view_from_world[3];
}

Camera Camera::placed(const glm::dvec3& new_origin) const {
  Camera result = *this;
  if (new_origin == glm::dvec3(0) || new_origin == origin) return result;
  result.view_from_world[3] += glm::dmat3(view_from_world) * (new_origin - origin);
  result.origin = new_origin;
  return result;
}

Camera Camera::resized(int new_width, int new_height) const {
  Camera result = *this;
  const double scale = static_cast<double>(new_height) / height;
  const glm::dvec2 offset = center_px - 0.5 * glm::dvec2(width - 1, height - 1);
  result.focal_px = focal_px * scale;
  result.center_px = 0.5 * glm::dvec2(new_width - 1, new_height - 1) + offset * scale;
  result.width = new_width;
  result.height = new_height;
  return result;
}

Camera Camera::reduced(int divisor) const {
  Camera result = *this;
  result.width = std::max(1, width / divisor);
  result.height = std::max(1, height / divisor);
  const glm::dvec2 scale = glm::dvec2(result.width, result.height) / glm::dvec2(width, height);
  result.focal_px = focal_px * scale;
  result.center_px = (center_px + 0.5) * scale - 0.5;
  return result;
}

Camera look_at(glm::dvec3 position, glm::dvec3 target, glm::dvec3 up, double vertical_fov,
               int width, int height) {
  const glm::dvec3 forward = glm::normalize(target - position);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
  const glm::dmat3 rotation =
      glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  return {glm::dmat4x3(rotation[0], rotation[1], rotation[2], -(rotation * position)),
          glm::dvec2(0.5 * height / std::tan(0.5 * vertical_fov)),
          0.5 * glm::dvec2(width - 1, height - 1), width, height};
}

namespace {

/// A Gaussian outside of a face reaches into it, so its Jacobian is taken at the face's edge and
/// not beyond. Measured in docs/log/lenses.md; the pinhole's kSlopeMargin is as published.
constexpr double kFaceSlopeMargin = 0.9;

/// View::slope_limit.
glm::dvec2 slope_limit(const Camera& camera) {
  const glm::dvec2 size(camera.width, camera.height);
  if (camera.projection == Projection::orthographic) return glm::dvec2(0);
  if (camera.projection == Projection::pinhole)
    return kSlopeMargin * size / (2.0 * camera.focal_px);
  if (camera.face_edge > 0) return glm::dvec2(kFaceSlopeMargin * camera.face_edge);
  const glm::dvec2 farthest = glm::max(camera.center_px + 0.5, size - 0.5 - camera.center_px);
  return glm::dvec2(kFaceSlopeMargin * glm::max(farthest.x, farthest.y)) / camera.focal_px;
}

/// The point from which a Gaussian's colour is seen. Parallel rays come from so far behind the
/// camera that in single precision the direction to every Gaussian is the same.
glm::dvec3 eye_of(const Camera& camera) {
  constexpr double kFar = 1e15;
  if (camera.projection != Projection::orthographic) return camera.position();
  return camera.position() - kFar * glm::transpose(glm::dmat3(camera.view_from_world))[2];
}

}  // namespace

template <class Real>
View<Real> make_view(const Camera& camera) {
  using Pair = glm::vec<2, Real>;
  return {glm::mat<4, 3, Real>(camera.view_from_world),
          glm::vec<3, Real>(eye_of(camera)),
          Pair(camera.focal_px),
          Pair(camera.center_px),
          Pair(slope_limit(camera)),
          static_cast<Real>(camera.near_depth),
          camera.projection};
}

template View<float> make_view<float>(const Camera&);
template View<double> make_view<double>(const Camera&);

}  // namespace qs
