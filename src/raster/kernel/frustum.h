// SPDX-License-Identifier: MIT
//
// Finds the blocks of Gaussians that a view cannot show from a bounding box and a largest size per
// block.
//
// A mode lists no tile of a Gaussian whose mean is further outside of the image than its reach. For
// the left side:
//   mean_x + reach < 0,   mean_x = fx x/z + cx,   reach = k sqrt(level (Sxx + Syy)) + 2 tiles.
// The sum of the undilated variances is at most (spread sigma / z)^2 for every shape. Splitting the
// root and multiplying by z > 0 shows that the condition holds if
//   fx x + (cx + k sqrt(2 level dilation) + 2 tiles) z + k sqrt(level) spread sigma < 0.
// This is linear in the position, so its largest value over a box is at a corner. It does not
// divide by the depth, so blocks that cross the camera's plane need no special case. In an
// orthographic view the same holds with 1 in place of z.
#pragma once

#include <glm/geometric.hpp>

#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs {

/// No mode lists a tile further from the mean than k sqrt(level (Sxx + Syy)) + 2 tiles in pixels,
/// with k = kReachK + kReachKPerF2 / f^2 (see Extents) and level = max(gamma, kSigmas^2).
inline constexpr float kReachK = 1.01f, kReachKPerF2 = 3e-7f;

/// Bounds of all Gaussians of a block that a view can show.
struct BlockBounds {
  glm::vec3 low{INFINITY}, high{-INFINITY};  ///< box around the centres, world
  float sigma = 0;                           ///< upper bound of the standard deviations, world

  /// A Gaussian with a NaN has no footprint, and min() and max() ignore it.
  QS_HD void include(const glm::vec3& position, const Covariance3<float>& c) {
    low = glm::min(low, position);
    high = glm::max(high, position);
    // The norm of a matrix is an upper bound of its largest eigenvalue.
    const float norm = std::sqrt(c.xx * c.xx + c.yy * c.yy + c.zz * c.zz +
                                 2 * (c.xy * c.xy + c.xz * c.xz + c.yz * c.yz));
    sigma = glm::max(sigma, std::sqrt(norm));
  }
};

/// The part of the world that a view shows, enlarged for footprints and for rounding.
class Frustum {
 public:
  QS_HD Frustum(const View<float>& view, const FootprintRules& rules, TileGrid grid)
      : Frustum(view, rules, {0, 0}, double{kTileSize} * glm::dvec2(grid.columns, grid.rows)) {}

  /// Of the tiles between two corners, in pixels.
  QS_HD Frustum(const View<float>& view, const FootprintRules& rules, const glm::dvec2& low,
                const glm::dvec2& high)
      : is_parallel_(view.projection == Projection::orthographic),
        near_depth_(view.projection == Projection::face ? 0 : static_cast<double>(view.near_depth)),
        usual_spread_(kLargestSigmas * std::sqrt(static_cast<double>(rules.dilation))),
        root_of_level_(rules.is_solid ? kRootOfSolidLevel : kRootOfLevel),
        depth_(in_view(view, 0, 0, 1, 0)) {
    const glm::dvec2 focal(view.focal_px), center(view.center_px), limit(view.slope_limit);
    spread_ = static_cast<double>(rules.splat_scale) *
              std::sqrt(focal.x * focal.x * stretch2(view, 0, limit.x) +
                        focal.y * focal.y * stretch2(view, 1, limit.y));
    const double level = rules.is_solid ? kSolidLevel : kLevel;
    // dilate() enlarges a variance at most by the square of this factor.
    const double dilated =
        view.projection == Projection::face ? 1 + limit.x * limit.x + limit.y * limit.y : 1;
    const double room =
        kLargestK * dilated * std::sqrt(2 * level * static_cast<double>(rules.dilation)) +
        2 * kTileSize;
    for (int side = 0; side < 4; ++side) {
      const int axis = side / 2;
      const double across = side % 2 == 0 ? focal[axis] : -focal[axis];
      const double inside =
          (side % 2 == 0 ? center[axis] - low[axis] : high[axis] - center[axis]) + room;
      sides_[side] = is_parallel_ ? in_view(view, axis, across, 0, inside)
                                  : in_view(view, axis, across, inside, 0);
    }
  }

  /// True only if no mode lists a tile of a Gaussian in the block.
  QS_HD bool misses(const BlockBounds& bounds) const {
    if (depth_.largest(bounds) < near_depth_) return true;
    const double spread = spread_ * static_cast<double>(bounds.sigma);  // in px times depth
    const double nearest = is_parallel_ ? 1 : glm::max(depth_.smallest(bounds), near_depth_);
    const double k = spread < usual_spread_ * nearest ? kUsualK : kLargestK;
    const double reach = k * root_of_level_ * spread;
    for (const Linear& inside : sides_)
      if (inside.largest(bounds) + reach < 0) return true;
    return false;
  }

  /// Bounds of the depths of a block's centres.
  QS_HD glm::dvec2 depths(const BlockBounds& bounds) const {
    return {depth_.smallest(bounds), depth_.largest(bounds)};
  }

  /// Upper bound of the distance from a centre to a pixel with alpha >= 1/255, px.
  QS_HD float reach_px(float sigma, float nearest_depth) const {
    const double spread = spread_ * static_cast<double>(sigma) / static_cast<double>(nearest_depth);
    return static_cast<float>(root_of_level_ * (spread + usual_spread_ / kLargestSigmas) + 1);
  }

 private:
  /// Upper bound of max(gamma, kSigmas^2) in project(), and of its root: gamma is at most 2 ln 255
  /// = 11.08.
  static constexpr double kLevel = 11.1, kRootOfLevel = 3.3317;
  static_assert(kLevel > 2 * kLn2 * static_cast<double>(kLog2Of255));
  static_assert(kRootOfLevel * kRootOfLevel > kLevel);
  static constexpr double kSolidLevel = 99.9, kRootOfSolidLevel = 9.996;
  static_assert(kSolidLevel > double{kSolidGamma});
  static_assert(kRootOfSolidLevel * kRootOfSolidLevel > kSolidLevel);

  /// Upper bound of k = kReachK + kReachKPerF2 / f^2, f^2 = det / (Sxx Syy). In single precision a
  /// determinant is at least 2^-24 of that product, or 0 and the Gaussian is dropped.
  static constexpr double kLargestK = 7;
  static_assert(kLargestK > static_cast<double>(kReachK + (1 << 24) * kReachKPerF2));

  /// A smaller bound of k for standard deviations below kLargestSigmas roots of the dilation. There
  /// the dilation keeps f^2 above (2/3) / 1.7e5 - 3 * 2^-24, all rounding errors (1e-6 of the
  /// largest variance, or 1/3 of the dilation) included.
  static constexpr double kLargestSigmas = 400, kUsualK = 1.2;

  /// Bound of the relative error of a position in view axes and of its pixel in single precision:
  /// about ten roundings of 2^-24, and a margin.
  static constexpr double kError = 4e-6;

  /// A linear function of the position p: dot(slope, p) + offset.
  struct Linear {
    glm::dvec3 slope;
    double offset;
    // Bound of the error in single precision: dot(slope_error, |p|) + offset_error.
    glm::dvec3 slope_error;
    double offset_error;

    /// Upper bound in the box.
    QS_HD double largest(const BlockBounds& bounds) const {
      const glm::dvec3 low(bounds.low), high(bounds.high);
      const glm::dvec3 farthest = glm::max(slope * low, slope * high) +
                                  slope_error * glm::max(glm::abs(low), glm::abs(high));
      return farthest.x + farthest.y + farthest.z + offset + offset_error;
    }

    /// Lower bound in the box.
    QS_HD double smallest(const BlockBounds& bounds) const {
      return -Linear{-slope, -offset, slope_error, offset_error}.largest(bounds);
    }
  };

  /// Row `axis` of the view's rotation.
  static QS_HD glm::dvec3 row(const View<float>& view, int axis) {
    const auto& m = view.view_from_world;
    return {m[0][axis], m[1][axis], m[2][axis]};
  }

  /// Upper bound of |row `axis` + s row 2|^2 of the view's rotation for |s| <= limit.
  static QS_HD double stretch2(const View<float>& view, int axis, double limit) {
    const glm::dvec3 across = row(view, axis), along = row(view, 2);
    limit = glm::abs(limit);
    return glm::dot(across, across) + 2 * limit * glm::abs(glm::dot(across, along)) +
           limit * limit * glm::dot(along, along);
  }

  /// across * (x or y, by `axis`) + along * z + constant, of the position in view axes.
  static QS_HD Linear in_view(const View<float>& view, int axis, double across, double along,
                              double constant) {
    const glm::dvec3 of_axis = row(view, axis), of_depth = row(view, 2);
    const auto& m = view.view_from_world;
    const double shift = static_cast<double>(m[3][axis]), depth = static_cast<double>(m[3][2]);
    return {across * of_axis + along * of_depth, across * shift + along * depth + constant,
            kError * (glm::abs(across * of_axis) + glm::abs(along * of_depth)),
            kError * (glm::abs(across * shift) + glm::abs(along * depth) + glm::abs(constant))};
  }

  bool is_parallel_;
  double near_depth_;     ///< of view z; a face compares distances, which are not less
  double usual_spread_;   ///< px; smaller footprints reach only a little beyond their box
  double root_of_level_;  ///< of the largest gamma
  double spread_;         ///< upper bound of px per (sigma / depth), or per sigma
  Linear depth_;          ///< view z
  Linear sides_[4];       ///< px inside of each side of the image, times depth if not parallel
};

}  // namespace qs
