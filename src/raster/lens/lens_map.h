// SPDX-License-Identifier: MIT
//
// The map from faces to a picture of a lens. Faces are pinhole pictures around one eye. Each shows
// a cell of all directions: a side of a cube, or a quarter of one. Next to the border of two cells
// a pixel is blended from both faces, over kBlendDegrees.
#pragma once

#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "raster/lens/lens_view.h"
#include "raster/scene/camera.h"

namespace qs {

inline constexpr double kBlendDegrees = 2;

/// A pixel of the picture, and the place in a face from which it is interpolated.
struct FacePixel {
  std::uint32_t pixel;  ///< row by row
  float x, y;           ///< px of the face
  float weight;         ///< the weights of a pixel in all faces have the sum 1
};

struct FaceMap {
  glm::dmat3 lens_from_face{1.0};  ///< columns right, down, forward of the face
  Camera camera;                   ///< without a pose; only as large as the pixels need
  std::vector<FacePixel> pixels;   ///< in the order of the picture

  /// The face's camera at the eye of `lens`.
  Camera placed(const Camera& lens) const;
};

struct LensMap {
  glm::ivec2 size{0};
  std::vector<FaceMap> faces;    ///< with at least one pixel
  double middle_pixel_area = 1;  ///< px^2 of a face in the middle of the lens
  /// Per pixel: the index of the face with the largest weight; kNoFace: the lens shows nothing.
  std::vector<std::uint8_t> nearest;

  static constexpr std::uint8_t kNoFace = 255;
};

/// The maps that are kept: of the view at rest and of the moving one.
inline constexpr std::size_t kMostMaps = 2;

/// `faces`: kManyFaces or kFewFaces.
LensMap make_lens_map(const SizedLens& lens, glm::ivec2 size, int faces, ThreadPool& pool);

}  // namespace qs
