// SPDX-License-Identifier: MIT
//
// Lenses, and the pinhole cameras that replace them. A photograph is undistorted when it is read;
// from then on its camera is a pinhole camera. A photograph that one pinhole camera cannot show is
// divided into faces: six pinhole cameras around the eye, turned by right angles.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "io/camera/lens_models.h"
#include "raster/scene/camera.h"

namespace qs {

/// Smaller coefficients count as none: under 0.01 px at the edge of a picture of 10,000 px.
inline constexpr double kNoDistortion = 1e-6;

/// The lens of a photograph. Pixels count from pixel centres.
struct Lens {
  const LensModel* model = nullptr;
  glm::dvec2 size_px{0.0};  ///< of the photograph to which the pixels refer
  glm::dvec2 focal_px{0.0}, center_px{0.0};
  std::array<double, 12> coefficients{};
  /// The largest distance in the model's plane at which no direction is shown twice.
  double limit = 0;
  /// The face that the camera shows, a name of kFaces. Empty: one pinhole camera shows the
  /// photograph. kAllFaces: views_of() divides it.
  std::string_view face = "";

  /// The pixel of a direction in the lens's axes: x right, y down, z forward, of any length above
  /// 0. Unset outside the limit and outside the model's widest angle.
  std::optional<glm::dvec2> project(glm::dvec3 direction) const;

  /// The direction of a pixel, of any length; the inverse of project(), by Newton's method. Unset
  /// if no direction within the limit is shown there.
  std::optional<glm::dvec3> direction(glm::dvec2 pixel) const;

  /// True if the photograph has the point, at least `margin` pixels from its edge.
  bool has_pixel(glm::dvec2 pixel, double margin = 0) const;

  /// The lens for the photograph in another resolution.
  Lens scaled(glm::dvec2 factor) const;
};

inline constexpr std::string_view kAllFaces = "all";

struct Face {
  std::string_view name;
  glm::dmat3 lens_from_face;
};

/// Nullptr if there is no such face. The faces are front, right, back, left, up and down.
const Face* find_face(std::string_view name);

/// The camera of a photograph.
struct LensCamera {
  Camera camera;             ///< the undistorted photograph's; of a divided one, the front face's
  std::optional<Lens> lens;  ///< the lens that took the photograph; unset: no distortion
  /// The photograph as the cameras file names it: photographs.h finds the file. Empty: the name of
  /// the camera is all that is known.
  std::string photograph = {};
  std::string mask = {};  ///< as the cameras file names it; empty: it names none

  /// True if it shows one face of a photograph that several cameras share.
  bool is_face() const { return lens && find_face(lens->face) != nullptr; }

  /// This view in another resolution: each axis is scaled by its own factor.
  LensCamera scaled(int width, int height) const;

  /// Pixels of the photograph to which the intrinsics refer.
  glm::dvec2 photograph_size() const;

  /// The camera with the lens's pose and the photograph's size, to be drawn through the lens.
  Camera taken() const;

  /// The photograph's pixel at a pixel of the camera. Unset if the lens does not show the
  /// direction, or if the photograph ends before it or, of a face, before a pixel from which it is
  /// interpolated.
  std::optional<glm::dvec2> source_of(glm::dvec2 pixel) const;
};

/// The lens with its limit. A panorama gets its intrinsics, which follow from its size. Throws
/// Error(input) "WHERE: ..." for numbers out of range, and NotFinite.
Lens checked_lens(Lens lens, const std::string& where);

/// True if no pinhole camera of the same focal lengths shows the same picture.
bool distorts(const Lens& lens);

/// The camera of a lens; without distortion it has none. Throws as checked_lens() and
/// undistorted_camera() do.
LensCamera lens_camera(const Lens& lens, const std::string& where);

/// The pinhole camera for a lens, with its principal point: its focal lengths are the lens's focal
/// lengths times the smallest factor for which every pixel of the undistorted photograph is inside
/// the photograph. A lens of more than 100 degrees, and a lens for which there is no such factor up
/// to 2, gets faces of 96 degrees: the result is the front face, and views_of() has all faces.
/// Throws Error(input) "WHERE: ..." if the lens shows less than a tenth of every face.
LensCamera undistorted_camera(const Lens& lens, const std::string& where);

/// The pinhole cameras of a photograph: the camera itself, or the faces of which the photograph
/// shows a tenth at least, named NAME_front and so on.
std::vector<LensCamera> views_of(const LensCamera& camera);

/// The camera that draws a view to compare it with its photograph. A face is drawn such that a
/// direction has one colour in all faces (Projection::face).
Camera compared_camera(Camera camera, const std::optional<Lens>& lens);

/// True if camera i and the camera before it are faces of one photograph.
bool is_next_face(const std::vector<LensCamera>& cameras, std::size_t i);

/// The share of the photograph's area that views_of() show, 0 to 1, from points all over the
/// photograph: within 0.005.
double used_share(const LensCamera& camera);

/// Cameras of equal names keep their order. The faces of a photograph are one after another: their
/// names count without the face.
void sort_by_name(std::vector<LensCamera>& cameras);

/// The cameras without their lenses.
std::vector<Camera> pinhole_cameras(const std::vector<LensCamera>& cameras);

}  // namespace qs
