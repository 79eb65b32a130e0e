// SPDX-License-Identifier: MIT
//
// The models of lenses, a table with one row per model: COLMAP's by name and number, and models of
// other programs by name. A lens projects a direction in two steps: a plane holds directions as
// points, and bend() moves the points. To add a model: add a row, and its golden points to
// tests/io/camera/lens_models_test.cpp. Sources of the formulas: COLMAP's
// src/colmap/sensor/models; for METASHAPE the appendix "Camera models" of Metashape's manual; for
// FISHEYE624 camera_utils.py of nerfstudio and "The FisheyeRadTanThinPrism model" of Project Aria's
// documentation, which has coefficients in the same order.
#pragma once

#include <span>
#include <string_view>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace qs {

/// The point of a direction (x, y, z), z forward.
enum class LensPlane {
  perspective,  ///< (x / z, y / z)
  equidistant,  ///< (x, y) at a distance of the angle to the axis, radians
  panorama,     ///< azimuth and elevation below the horizon, radians
};

struct LensModel {
  int id;  ///< COLMAP's number; -1: it has none
  std::string_view name;
  /// The first parameters, before the principal point; 0: the parameters are the picture's sides.
  int focal_lengths;
  std::string_view names;  ///< of the coefficients after the principal point, in order
  bool pinhole;            ///< a pinhole camera if its coefficients are 0
  LensPlane plane;
  double widest;  ///< radians to the axis: the largest angle of any lens of this model
  glm::dvec2 (*bend)(glm::dvec2 point, const double* coefficients);

  int coefficients() const;
  int parameters() const;
  /// The name of coefficient i.
  std::string_view coefficient(int i) const;
};

std::span<const LensModel> lens_models();

/// nullptr if there is no such model.
const LensModel* find_lens_model(int id);
const LensModel* find_lens_model(std::string_view name);

/// The point in the plane; `direction` has any length above 0. A direction at or behind the plane
/// of the eye has no point in the plane `perspective`: infinity.
glm::dvec2 to_plane(LensPlane plane, glm::dvec3 direction);

/// The direction of a point, of any length.
glm::dvec3 from_plane(LensPlane plane, glm::dvec2 point);

/// The derivative of bend() in the plane, by central differences: its columns.
struct BendDerivative {
  glm::dvec2 by_x, by_y;
  double determinant() const { return by_x.x * by_y.y - by_x.y * by_y.x; }
};
BendDerivative bend_derivative(const LensModel& model, glm::dvec2 point,
                               const double* coefficients);

/// The largest distance from the plane's origin within which the model shows no direction twice:
/// the smallest at which the determinant of the derivative is not above 0, searched by rings.
double fold_radius(const LensModel& model, const double* coefficients);

}  // namespace qs
