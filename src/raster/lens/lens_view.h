// SPDX-License-Identifier: MIT
//
// A lens through which frames are drawn, see RenderSettings::lens: a panorama, a fisheye, any model
// of io/camera/lens_models.h, or parallel rays. io/camera/lens_views.h makes them.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace qs {

/// A lens in front of a picture of one size.
struct SizedLens {
  /// The direction that a pixel shows, in view axes and of any length; unset if it shows nothing.
  /// Called by several threads.
  std::function<std::optional<glm::dvec3>(glm::dvec2 pixel)> direction;
  double pixels_per_radian = 0;  ///< the most, along lines through the axis or the poles; > 0
  double middle_pixels_per_radian = 0;  ///< on the axis: the dilation is of its pixels; > 0
};

inline constexpr int kManyFaces = 24, kFewFaces = 6;

struct LensView {
  /// Names the lens to users, with all its numbers: lenses of equal texts are equal.
  std::string text;
  /// The lens in front of the picture of one eye. Null: the rays are parallel.
  std::function<SizedLens(glm::ivec2 size)> sized = {};
  double height = 0;                  ///< of a picture of parallel rays, world units, > 0
  int faces = kManyFaces;             ///< kFewFaces is quicker and less exact
  std::optional<glm::dvec3> up = {};  ///< levels the horizon: up in the world
  double eye_distance =
      0;  ///< world units; above 0: the picture of the left eye is above the right

  bool is_parallel() const { return !sized; }
};

/// True if frames through the lens, which may be null, are drawn as faces.
inline bool has_faces(const std::shared_ptr<const LensView>& lens) {
  return lens && !lens->is_parallel();
}

/// The axes of the faces of a cube in view axes: columns right, down and forward of the faces
/// front, right, back, left, up and down.
inline const std::array<glm::dmat3, 6> kCubeAxes = {{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                                     {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}},
                                                     {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
                                                     {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}},
                                                     {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                                                     {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}}};

}  // namespace qs
