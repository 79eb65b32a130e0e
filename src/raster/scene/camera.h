// SPDX-License-Identifier: MIT
//
// A pinhole camera, or an orthographic one. View axes are RDF: x right, y down, z forward. The
// image's origin is top-left. Pixel i has its centre at coordinate i, so a centred principal point
// is ((W-1)/2, (H-1)/2). COLMAP puts it at i + 0.5, so its cx is larger by 0.5.
#pragma once

#include <string>

#include <glm/mat4x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/view.h"

namespace qs {

struct Camera {
  glm::dmat4x3 view_from_world{1.0};  ///< rotation columns and translation, world units
  glm::dvec2 focal_px{0.0};           ///< fx, fy in pixels, > 0
  glm::dvec2 center_px{0.0};          ///< principal point, pixel-centre coordinates
  int width = 0, height = 0;          ///< pixels, > 0
  double near_depth = 0.2;            ///< Gaussians at this depth or less are not drawn
  std::string name = {};              ///< name of the photograph, without extension; may be empty
  glm::dvec3 origin{0.0};  ///< its place counts from here in the world, see GaussianCloud::origin
  Projection projection = Projection::pinhole;
  /// Of Projection::face: the largest |x/z| and |y/z| of the whole face, of which the picture may
  /// be a part; 0: the picture is the whole face.
  double face_edge = 0;

  /// Camera position in the world.
  glm::dvec3 position() const;

  /// The same camera for a cloud with that origin. A cloud without an origin is where its cameras
  /// are: then nothing moves.
  Camera placed(const glm::dvec3& new_origin) const;

  /// The same view at another size, in pixels, > 0. The vertical field of view stays; focal lengths
  /// and the principal point's offset from the image centre scale with the height.
  Camera resized(int new_width, int new_height) const;

  /// The same picture with 1 / divisor of its width and height, at least a pixel. Every point keeps
  /// its place in it.
  Camera reduced(int divisor) const;
};

/// A camera at `position` that looks at `target`. `up` points up in the world and must not be
/// parallel to the line of sight. `vertical_fov` is in radians. The principal point is the image
/// centre.
Camera look_at(glm::dvec3 position, glm::dvec3 target, glm::dvec3 up, double vertical_fov,
               int width, int height);

/// The camera as the kernels read it, rounded to Real.
template <class Real>
View<Real> make_view(const Camera& camera);

}  // namespace qs
