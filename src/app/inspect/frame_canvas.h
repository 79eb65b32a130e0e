// SPDX-License-Identifier: MIT
//
// An enlarged window of a frame to draw on, with its tile grid. All drawing uses the frame's pixel
// coordinates: the centre of pixel i is at i. As in the culling modes, the borders of tiles are at
// multiples of their side.
#pragma once

#include <span>

#include "app/inspect/gaussian.h"
#include "app/picture/stroke.h"

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

}  // namespace qs
