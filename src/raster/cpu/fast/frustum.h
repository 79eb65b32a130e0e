// SPDX-License-Identifier: MIT
//
// Finds the blocks that a view cannot show from a bounding box and a largest size per block.
#pragma once

#include <array>

#include <glm/vec3.hpp>

#include "raster/cpu/fast/blocks.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::fast {

/// Bounds of all Gaussians of a block that a view can show.
struct BlockBounds {
  glm::vec3 low, high;  ///< box around the centres, world
  float sigma;          ///< upper bound of the standard deviations, world units
};

BlockBounds bounds_of(const Block& block);

/// The part of the world that a view shows, enlarged for footprints and for rounding.
class Frustum {
 public:
  Frustum(const View<float>& view, const FootprintRules& rules, TileGrid grid);

  /// True only if project() would keep no Gaussian of the block.
  bool misses(const BlockBounds& bounds) const;

 private:
  /// A linear function of the position p: dot(slope, p) + offset.
  struct Linear {
    glm::dvec3 slope;
    double offset;
    // Bound of the error in single precision: dot(slope_error, |p|) + offset_error.
    glm::dvec3 slope_error;
    double offset_error;

    double smallest(const BlockBounds& bounds) const;  ///< lower bound in the box
    double largest(const BlockBounds& bounds) const;   ///< upper bound in the box
  };

  /// across * (x or y, by `axis`) + along * z of the position in view axes.
  static Linear in_view(const View<float>& view, int axis, double across, double along);

  double near_depth_;
  double usual_spread_;          ///< px; smaller footprints reach only a little beyond their box
  double spread_;                ///< upper bound of px per (sigma / depth)
  Linear depth_;                 ///< view z
  std::array<Linear, 4> sides_;  ///< px inside of each side of the image, times depth
};

}  // namespace qs::cpu::fast
