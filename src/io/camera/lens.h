// SPDX-License-Identifier: MIT
//
// Lenses that distort, and the pinhole cameras that replace them. A photograph is undistorted when
// it is read; from then on its camera is a pinhole camera.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>

#include "raster/scene/camera.h"

namespace qs {

/// COLMAP's model OPENCV, which contains SIMPLE_RADIAL (k1) and RADIAL (k1, k2). Pixels refer to
/// the camera's image size and count from pixel centres. Smaller coefficients count as none: under
/// 0.01 px at the edge of a picture of 10,000 px.
inline constexpr double kNoDistortion = 1e-6;

struct Lens {
  glm::dvec2 focal_px{0.0}, center_px{0.0};
  double k1 = 0, k2 = 0;  ///< radial
  double p1 = 0, p2 = 0;  ///< tangential

  /// The direction at which the lens shows the direction (x/z, y/z):
  ///   x (1 + k1 r^2 + k2 r^4) + 2 p1 x y + p2 (r^2 + 2 x^2)
  ///   y (1 + k1 r^2 + k2 r^4) + 2 p2 x y + p1 (r^2 + 2 y^2)
  glm::dvec2 distort(glm::dvec2 slope) const;
};

/// The coefficients of a lens with their names in files, in COLMAP's order.
inline constexpr std::pair<const char*, double Lens::*> kDistortion[] = {
    {"k1", &Lens::k1}, {"k2", &Lens::k2}, {"p1", &Lens::p1}, {"p2", &Lens::p2}};

/// The camera of a photograph.
struct LensCamera {
  Camera camera;             ///< the undistorted photograph's
  std::optional<Lens> lens;  ///< the lens that took the photograph; unset: no distortion
  /// The photograph as the cameras file names it: photographs.h finds the file. Empty: the name of
  /// the camera is all that is known.
  std::string photograph = {};
  std::string mask = {};  ///< as the cameras file names it; empty: it names none

  /// This view in another resolution: each axis is scaled by its own factor.
  LensCamera scaled(int width, int height) const;
};

/// The pinhole camera for a lens, of the size and principal point of `size`: its focal lengths are
/// the lens's focal lengths times the smallest factor for which every pixel of the undistorted
/// photograph is inside the photograph. Throws Error(input) "WHERE: ..." if the lens shows a
/// direction twice.
LensCamera undistorted_camera(const Camera& size, const Lens& lens, const std::string& where);

/// Cameras of equal names keep their order.
void sort_by_name(std::vector<LensCamera>& cameras);

/// The cameras without their lenses.
std::vector<Camera> pinhole_cameras(const std::vector<LensCamera>& cameras);

}  // namespace qs
