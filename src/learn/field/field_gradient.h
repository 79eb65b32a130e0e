// SPDX-License-Identifier: MIT
//
// A colour field in training: its outputs for one Gaussian, and the gradient by the hash grid, the
// network and the direction. Real is float, or double to check gradients. Sums of gradients do not
// depend on the order in which threads add to the grid: they are integers.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "learn/field/integer_sums.h"
#include "raster/field/color_field.h"

namespace qs {

template <class Real>
class FieldGradient {
 public:
  static constexpr std::size_t kMostInputs = 64, kMostWidth = 64;

  /// Values of `grid` and `weights` are in the order of ColorField. `grid` must outlive this.
  /// Throws std::length_error if the network is larger than published ones.
  FieldGradient(const GridShape& shape, int width, std::span<const Real> grid,
                std::span<const Real> weights);

  std::size_t grid_values() const { return grid_.size(); }
  std::size_t weights() const { return weights_.size(); }

  /// The three outputs for a mean in the world, seen from `eye`, as FieldEvaluator::outputs().
  glm::vec<3, Real> output(const glm::vec<3, Real>& mean, const glm::vec<3, Real>& eye) const;

  /// `d_output` holds derivatives by these outputs. Adds the derivatives by the grid and by the
  /// weights to `grid` and `weights`. Returns the derivative by the unit vector from `eye` to
  /// `mean`. The position in the grid passes no derivative on, as in the published code.
  glm::vec<3, Real> add(const glm::vec<3, Real>& mean, const glm::vec<3, Real>& eye,
                        const glm::vec<3, Real>& d_output, IntegerSums& grid,
                        std::span<Real> weights) const;

 private:
  struct Pass;

  void run(const glm::vec<3, Real>& mean, const glm::vec<3, Real>& eye, Pass& pass) const;

  std::vector<GridLevel> levels_;
  NetworkShape network_;
  std::span<const Real> grid_;
  std::vector<Real> weights_;
  std::vector<Real> columns_;  ///< the three matrices by columns
};

extern template class FieldGradient<float>;
extern template class FieldGradient<double>;

}  // namespace qs
