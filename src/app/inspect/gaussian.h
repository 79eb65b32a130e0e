// SPDX-License-Identifier: MIT
//
// Everything about one Gaussian in one view: its shape on the image, the boxes of every mode, the
// tiles that each mode lists, and the walk of QPass. It is computed from the footprint with the
// renderer's own functions, so that the counts equal the renderer's.
#pragma once

#include <vector>

#include "raster/api/renderer.h"

namespace qs {

/// The modes that figures and pages explain.
inline const CullMode k3dgs = find_culler("3dgs"), kAdr = find_culler("adr"),
                      kDual = find_culler("dualbox"), kQuad = find_culler("quadbox"),
                      kExact = find_culler("exact");

/// In pixel coordinates: the centre of pixel i is at i.
struct Box {
  glm::vec2 low{0.0f}, high{0.0f};
};

/// Consecutive tiles in one row or column of tiles, found by a mode that walks them.
struct TileRun {
  int line = 0;  ///< row of tiles if the mode walks rows, else column
  Span tiles{};  ///< columns in that row, or rows in that column; may be empty
};

/// The tiles that a mode lists for the Gaussian.
struct ModeTiles {
  CullMode mode = default_mode();
  std::vector<int> tiles;  ///< row * columns + column, in the mode's order
  bool walks_rows = false;
  std::vector<TileRun> runs;  ///< lines of the walk, in order; empty for modes without one
};

struct GaussianReport {
  std::uint32_t gaussian = 0;  ///< index in the cloud
  float depth = 0;             ///< view z
  float opacity = 0;           ///< 0..1, after antialiasing
  glm::vec3 color{0.0f};
  Footprint footprint{};      ///< mean, covariance, conic, gamma
  float f = 0;                ///< stretch of the minor boxes, 0 < f <= 1
  glm::vec2 half_axes{0.0f};  ///< half axes of the ellipse, pixels, longer one first
  float anisotropy = 1;       ///< longer over shorter half axis
  float tilt = 0;        ///< angle of the longer axis from +x towards +y, radians, -pi/2 .. pi/2
  bool visible = false;  ///< opacity above 1/255: the ellipse exists
  Box square;            ///< the box of mode 3dgs
  Box adr;               ///< the ellipse's bounding box
  std::vector<Box> dual_boxes;   ///< its two quadrants along the major axis
  std::vector<Box> quad_boxes;   ///< four
  std::vector<ModeTiles> modes;  ///< index = CullMode - 1
};

/// The Gaussian in `slot` of the trace.
GaussianReport inspect_gaussian(const Trace& trace, std::size_t slot, const TileGrid& grid);

/// The tiles that the renderer lists in mode `mode`. For any tile size.
ModeTiles mode_tiles(CullMode mode, const Footprint& footprint, const TileGrid& grid);

/// The number of mode_tiles().
std::uint32_t count_mode_tiles(CullMode mode, const Footprint& footprint, const TileGrid& grid);

/// GaussianReport::anisotropy.
float anisotropy_of(const Footprint& footprint);
float tilt_of(const Footprint& footprint);

/// Longer half axis of the ellipse alpha = 1/255 in pixels; 0 if it does not exist.
float screen_radius_of(const Footprint& footprint);

/// `count` points on the ellipse alpha = 1/255 in pixel coordinates.
std::vector<glm::vec2> ellipse_of(const Footprint& footprint, int count);

}  // namespace qs
