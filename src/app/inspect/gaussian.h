// SPDX-License-Identifier: MIT
//
// A Gaussian under the magnifier: its shape on the image, the boxes of every mode around it, the
// tiles that they list, and QPass at work. All of it follows from the footprint by the functions
// that the renderer itself calls, so that counts here are the renderer's counts.
#pragma once

#include <vector>

#include "raster/renderer.h"

namespace qs {

/// In pixel coordinates: pixel i has its centre at i.
struct Box {
  glm::vec2 low{0.0f}, high{0.0f};
};

/// A run of tiles in one line of tiles of a mode's walk.
struct TileRun {
  int line = 0;  ///< row of tiles when the walk goes by rows, else a column
  Span tiles{};  ///< columns in that row, or rows in that column; may be empty
};

/// What a mode lists of the Gaussian.
struct ModeTiles {
  CullMode mode = kDefaultMode;
  std::vector<int> tiles;  ///< row * columns + column, in the order of the walk
  bool walks_rows = false;
  std::vector<TileRun> runs;  ///< in the walk's order; none in a mode without a walk
};

struct GaussianReport {
  std::uint32_t gaussian = 0;  ///< index in the cloud
  float depth = 0;             ///< view z
  float opacity = 0;           ///< 0..1, after antialiasing
  glm::vec3 color{0.0f};
  Footprint footprint{};         ///< mean, covariance, conic, gamma
  float f = 0;                   ///< stretch of the minor boxes, 0 < f <= 1
  glm::vec2 half_axes{0.0f};     ///< of the ellipse in pixels, the longer one first
  float anisotropy = 1;          ///< longer over shorter half axis
  float tilt = 0;                ///< of the longer axis from +x towards +y, radians, -pi/2 .. pi/2
  bool visible = false;          ///< opacity above 1/255: there is an ellipse
  Box square;                    ///< of mode 3dgs
  Box adr;                       ///< the ellipse's bounding box
  std::vector<Box> dual_boxes;   ///< two quadrants of it
  std::vector<Box> quad_boxes;   ///< four
  std::vector<ModeTiles> modes;  ///< every mode of kCullers but reference, in its order
};

/// The Gaussian in `slot` of the trace.
GaussianReport inspect_gaussian(const Trace& trace, std::size_t slot, const TileGrid& grid);

/// Tiles that a mode lists of a footprint, as the renderer's mode `mode` would. For any tile size.
ModeTiles mode_tiles(CullMode mode, const Footprint& footprint, const TileGrid& grid);

/// How many those are, without listing them.
std::uint32_t count_mode_tiles(CullMode mode, const Footprint& footprint, const TileGrid& grid);

/// Anisotropy and tilt as in GaussianReport, of any footprint.
float anisotropy_of(const Footprint& footprint);
float tilt_of(const Footprint& footprint);

/// Half of the ellipse's longer axis where alpha falls to 1/255, pixels; 0 without an ellipse.
float screen_radius_of(const Footprint& footprint);

/// `count` points on the ellipse alpha = 1/255, pixel coordinates.
std::vector<glm::vec2> ellipse_of(const Footprint& footprint, int count);

}  // namespace qs
