// SPDX-License-Identifier: MIT
//
// A window of a frame, enlarged, with its grid of tiles: the ground on which drawings about
// Gaussians are made. Drawing is in the frame's pixel coordinates: pixel i has its centre at i, and
// as in the rules of the culling modes a tile's line lies at a multiple of its side.
#pragma once

#include <span>

#include "app/inspect/gaussian.h"
#include "app/picture/stroke.h"

namespace qs {

class Magnifier {
 public:
  /// Shows `window` as large as fits into `size` pixels; `scale_limit` is the most that a pixel of
  /// the frame may measure.
  Magnifier(const Box& window, glm::ivec2 size, float scale_limit = 40);

  const Image& picture() const { return picture_; }
  Image& picture() { return picture_; }
  float scale() const { return scale_; }  ///< picture pixels per pixel of the frame
  glm::vec2 to_picture(glm::vec2 at) const { return (at - window_.low) * scale_; }

  /// The frame, `strength` of it over white.
  void draw_frame(const Image& color, float strength);
  void draw_grid(const TileGrid& grid, glm::vec2 image_size);

  void fill_tile(const TileGrid& grid, int tile, glm::vec3 color, float opacity);
  void outline_tile(const TileGrid& grid, int tile, const Pen& pen);
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

/// The smallest window of whole tiles around everything that the modes list of the Gaussian, with a
/// tile of room on every side; it may reach beyond the image.
Box window_of(const GaussianReport& report, const TileGrid& grid);

}  // namespace qs
