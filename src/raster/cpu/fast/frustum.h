// SPDX-License-Identifier: MIT
//
// Which blocks a view cannot show, told from a few numbers of each.
#pragma once

#include <array>

#include <glm/vec3.hpp>

#include "raster/cpu/fast/blocks.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::fast {

/// What holds for all Gaussians of a block that a view can show.
struct BlockBounds {
  glm::vec3 low, high;  ///< of the centres, world
  float sigma;          ///< world units; no standard deviation is larger
};

BlockBounds bounds_of(const Block& block);

/// The part of the world that a view shows, widened for footprints and for rounding.
class Frustum {
 public:
  Frustum(const View<float>& view, const FootprintRules& rules, TileGrid grid);

  /// True only where project() would keep no Gaussian of the block.
  bool misses(const BlockBounds& bounds) const;

 private:
  /// A linear function of the position p: dot(slope, p) + offset.
  struct Linear {
    glm::dvec3 slope;
    double offset;
    glm::dvec3 slope_error;  ///< how far single precision can be off: dot(slope_error, |p|) +
    double offset_error;     ///< offset_error

    double smallest(const BlockBounds& bounds) const;  ///< no value in the box is smaller
    double largest(const BlockBounds& bounds) const;   ///< no value in the box is larger
  };

  /// across * (x or y, by `axis`) + along * z of the position in view axes.
  static Linear in_view(const View<float>& view, int axis, double across, double along);

  double near_depth_;
  double spread_;                ///< standard deviations in px per sigma / depth, at most
  Linear depth_;                 ///< z
  std::array<Linear, 4> sides_;  ///< px inside of each side of the picture, times depth
};

}  // namespace qs::cpu::fast
