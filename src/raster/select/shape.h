// SPDX-License-Identifier: MIT
//
// Shapes in a picture that select Gaussians. Coordinates are pixels of the camera's full size; the
// centre of pixel i is at i.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "raster/api/renderer.h"

namespace qs {

/// The inside of polygons, or the surroundings of a stroke.
class Shape {
 public:
  /// The points with an odd number of edges to their right (even-odd rule). An edge has its upper
  /// end and not its lower end, so polygons that share an edge share no point. `corners` are finite
  /// and closed by an edge from the last to the first; less than three give nothing.
  static Shape polygon(std::span<const glm::dvec2> corners);
  /// The polygon with the corners `a` and `b` opposite of each other.
  static Shape rectangle(glm::dvec2 a, glm::dvec2 b);
  /// The points within `radius` of the line through `points`; of one point, a disc.
  static Shape stroke(std::span<const glm::dvec2> points, double radius);

  bool contains(glm::dvec2 point) const;
  /// 1 for the pixels from `first`, one of pixels(), to the right that it contains, else 0.
  void choose_row(glm::ivec2 first, std::span<std::uint8_t> row) const;

  /// True if a point of the shape's border is within this distance of the point.
  bool has_border_near(glm::dvec2 point, double distance) const;

  /// Pixels with centres that can be inside, at most [0, size.x) x [0, size.y).
  PixelBox pixels(glm::ivec2 size) const;

 private:
  struct Line {
    glm::dvec2 from, to;
  };

  Shape(std::vector<Line> lines, double radius);
  std::span<const Line> near(double y) const;

  double radius_;  ///< of a stroke; 0: a polygon
  glm::dvec2 low_{0.0}, high_{0.0};
  // Rows of equal height from low_.y to high_.y have the lines that reach into them.
  double row_height_ = 1;
  std::vector<std::size_t> row_begin_;
  std::vector<Line> lines_;
};

}  // namespace qs
