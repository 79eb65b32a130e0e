// SPDX-License-Identifier: MIT
//
// A drawing of the bounds of one Gaussian in every mode, to scale on its frame: the ellipse, the
// boxes of the modes on the tile grid, the lines that QPass walks, and for each mode its tiles with
// their PairUse. It is drawn on an enlarged window of the frame, in the frame's pixel coordinates:
// the centre of pixel i is at i. As in the culling modes, the borders of tiles are at multiples of
// their side.
#pragma once

#include <string>

#include "app/inspect/gaussian.h"
#include "app/inspect/inspection.h"
#include "app/picture/canvas.h"
#include "raster/scene/image.h"

namespace qs {

class FrameCanvas {
 public:
  /// Shows `window` as large as fits into `size` pixels, but at most `scale_limit` times enlarged.
  FrameCanvas(const Box& window, glm::ivec2 size, float scale_limit = 40);

  const Image& picture() const { return picture_; }
  Image& picture() { return picture_; }
  float scale() const { return scale_; }  ///< picture pixels per pixel of the frame
  glm::vec2 to_picture(glm::vec2 at) const { return (at - window_.low) * scale_; }

  /// Draws the frame over white with this opacity, 0..1.
  void draw_frame(const Image& color, float strength);
  void draw_grid(const TileGrid& grid, glm::vec2 image_size);

  void fill_box(const Box& box, glm::vec3 color, float opacity);
  void outline_box(const Box& box, const Pen& pen);
  void draw_ellipse(const Footprint& footprint, const Pen& pen, float fill_opacity);
  void draw_dot(glm::vec2 at, float radius, glm::vec3 color);
  void draw_line(glm::vec2 from, glm::vec2 to, const Pen& pen);

 private:
  Box window_;
  float scale_;
  Image picture_;
};

/// The borders of a tile. `tile`: row * columns + column.
Box box_of_tile(const TileGrid& grid, int tile);

/// The smallest window of whole tiles around the ellipse and all tiles that the modes list, plus
/// one tile on every side. It may extend beyond the image.
Box window_of(const GaussianReport& report, const TileGrid& grid);

struct ConstructionInput {
  const Inspection& inspection;  ///< has a picked Gaussian
  const Image& color;            ///< the frame
  TileGrid grid;
  std::string where;  ///< scene and view for the headline
};

/// A picture 1800 pixels wide.
Image draw_construction(const ConstructionInput& input);

}  // namespace qs
