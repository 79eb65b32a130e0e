// SPDX-License-Identifier: MIT
//
// project() drops a Gaussian if its depth z is too small, or if its mean is further outside of the
// image than its reach. For the left side:
//   mean_x + reach < 0,   mean_x = fx x/z + cx,   reach = k sqrt(level (Sxx + Syy)) + 2 tiles.
// The sum of the undilated variances is at most (spread sigma / z)^2 for every shape. Splitting the
// root and multiplying by z > 0 shows that the condition holds if
//   fx x + (cx + k sqrt(2 level dilation) + 2 tiles) z + k sqrt(level) spread sigma < 0.
// This is linear in the position, so its largest value over a box is at a corner. It does not
// divide by the depth, so blocks that cross the camera's plane need no special case.
#include "raster/cpu/fast/frustum.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "raster/cpu/fast/project.h"

namespace qs::cpu::fast {
namespace {

/// Upper bound of max(gamma, kSigmas^2) in project(): gamma is at most 2 ln 255 = 11.08.
constexpr double kLevel = 11.1;
static_assert(kLevel > 2 * kLn2 * static_cast<double>(kLog2Of255));

/// Upper bound of k = kReachK + kReachKPerF2 / f^2 in project(), f^2 = det / (Sxx Syy). In single
/// precision a determinant is at least 2^-24 of that product, or 0 and the Gaussian is dropped.
constexpr double kLargestK = 7;
static_assert(kLargestK > static_cast<double>(kReachK + (1 << 24) * kReachKPerF2));

/// A smaller bound of k for standard deviations below kLargestSigmas roots of the dilation. There
/// the dilation keeps f^2 above (2/3) / 1.7e5 - 3 * 2^-24, all rounding errors (1e-6 of the largest
/// variance, or 1/3 of the dilation) included.
constexpr double kLargestSigmas = 400, kUsualK = 1.2;

/// Bound of the relative error of a position in view axes and of its pixel in single precision:
/// about ten roundings of 2^-24, and a margin.
constexpr double kError = 4e-6;

/// Upper bound of |row `axis` + s row 2|^2 of the view's rotation for |s| <= limit.
double stretch2(const View<float>& view, int axis, double limit) {
  const auto row = [&](int r) {
    const auto& m = view.view_from_world;
    return glm::dvec3(m[0][r], m[1][r], m[2][r]);
  };
  const glm::dvec3 across = row(axis), along = row(2);
  limit = std::abs(limit);
  return glm::dot(across, across) + 2 * limit * std::abs(glm::dot(across, along)) +
         limit * limit * glm::dot(along, along);
}

}  // namespace

BlockBounds bounds_of(const Block& block) {
  BlockBounds bounds{glm::vec3(INFINITY), glm::vec3(-INFINITY), 0};
  float variance2 = 0;
  for (std::size_t lane = 0; lane < kBlock; ++lane) {
    // min() and max() ignore NaN. A Gaussian with a NaN has no footprint.
    const glm::vec3 p(block.x[lane], block.y[lane], block.z[lane]);
    bounds.low = glm::min(bounds.low, p);
    bounds.high = glm::max(bounds.high, p);
    // The norm of a matrix is an upper bound of its largest eigenvalue.
    const float xx = block.xx[lane], yy = block.yy[lane], zz = block.zz[lane];
    const float xy = block.xy[lane], xz = block.xz[lane], yz = block.yz[lane];
    variance2 =
        std::max(variance2, xx * xx + yy * yy + zz * zz + 2 * (xy * xy + xz * xz + yz * yz));
  }
  bounds.sigma = std::sqrt(std::sqrt(variance2));
  return bounds;
}

Frustum::Frustum(const View<float>& view, const FootprintRules& rules, TileGrid grid)
    : near_depth_(static_cast<double>(view.near_depth)),
      usual_spread_(kLargestSigmas * std::sqrt(static_cast<double>(rules.dilation))),
      depth_(in_view(view, 0, 0, 1)) {
  const glm::dvec2 focal(view.focal_px), center(view.center_px), limit(view.slope_limit);
  spread_ = static_cast<double>(rules.splat_scale) *
            std::sqrt(focal.x * focal.x * stretch2(view, 0, limit.x) +
                      focal.y * focal.y * stretch2(view, 1, limit.y));
  const double room =
      kLargestK * std::sqrt(2 * kLevel * static_cast<double>(rules.dilation)) + 2 * kTileSize;
  const glm::dvec2 size = static_cast<double>(kTileSize) * glm::dvec2(grid.columns, grid.rows);
  for (int axis = 0; axis < 2; ++axis) {
    const auto side = static_cast<std::size_t>(2 * axis);
    sides_[side] = in_view(view, axis, focal[axis], center[axis] + room);
    sides_[side + 1] = in_view(view, axis, -focal[axis], size[axis] - center[axis] + room);
  }
}

Frustum::Linear Frustum::in_view(const View<float>& view, int axis, double across, double along) {
  const auto& m = view.view_from_world;
  const auto sum = [&](int column, double a, double b, auto&& value) {
    return a * value(static_cast<double>(m[column][axis])) +
           b * value(static_cast<double>(m[column][2]));
  };
  const auto plain = [](double x) { return x; };
  const auto error = [](double x) { return kError * std::abs(x); };
  Linear linear;
  for (int i = 0; i < 3; ++i) {
    linear.slope[i] = sum(i, across, along, plain);
    linear.slope_error[i] = sum(i, std::abs(across), std::abs(along), error);
  }
  linear.offset = sum(3, across, along, plain);
  linear.offset_error = sum(3, std::abs(across), std::abs(along), error);
  return linear;
}

double Frustum::Linear::largest(const BlockBounds& bounds) const {
  const glm::dvec3 low(bounds.low), high(bounds.high);
  const glm::dvec3 farthest =
      glm::max(slope * low, slope * high) + slope_error * glm::max(glm::abs(low), glm::abs(high));
  return farthest.x + farthest.y + farthest.z + offset + offset_error;
}

double Frustum::Linear::smallest(const BlockBounds& bounds) const {
  return -Linear{-slope, -offset, slope_error, offset_error}.largest(bounds);
}

bool Frustum::misses(const BlockBounds& bounds) const {
  if (depth_.largest(bounds) < near_depth_) return true;
  const double spread = spread_ * static_cast<double>(bounds.sigma);  // in px times depth
  const double nearest = std::max(depth_.smallest(bounds), near_depth_);
  const double k = spread < usual_spread_ * nearest ? kUsualK : kLargestK;
  const double reach = k * std::sqrt(kLevel) * spread;
  return std::any_of(sides_.begin(), sides_.end(),
                     [&](const Linear& inside) { return inside.largest(bounds) + reach < 0; });
}

}  // namespace qs::cpu::fast
