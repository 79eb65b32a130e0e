// SPDX-License-Identifier: MIT
//
// Colour fields with parameters that follow a rule, for golden values.
#pragma once

#include <cmath>
#include <cstddef>

#include "raster/field/color_field.h"
#include "raster/kernel/half.h"

namespace qs::test {

/// Value `k` of the rule: 2 frac((k + 1) phi) - 1 in -1..1, times `bound`, rounded to half.
inline float golden_value(std::size_t k, double bound = 1) {
  const double v = static_cast<double>(k + 1) * 0.6180339887498949;
  return float_of_any_half(
      round_to_half(static_cast<float>(bound * (2 * (v - std::floor(v)) - 1))));
}

/// The field whose grid values and weights follow the rule; weights are scaled by
/// sqrt(6 / (rows + columns)).
inline ColorField golden_field(const GridShape& grid, int width) {
  ColorField field;
  field.grid = grid;
  field.width = width;
  field.grid_values.resize(grid_value_count(grid));
  for (std::size_t k = 0; k < field.grid_values.size(); ++k) field.grid_values[k] = golden_value(k);
  const NetworkShape shape = field.network();
  field.weights.resize(shape.weight_count());
  for (std::size_t k = 0; k < field.weights.size(); ++k) {
    const int sum = k < shape.second()  ? shape.width + shape.inputs()
                    : k < shape.third() ? 2 * shape.width
                                        : NetworkShape::kOutputs + shape.width;
    field.weights[k] = golden_value(k, std::sqrt(6.0 / sum));
  }
  return field;
}

inline constexpr GridShape kTinyGrid{4, 6, 3, 1.5f};

inline ColorField tiny_field() { return golden_field(kTinyGrid, 16); }
inline ColorField published_field() { return golden_field({}, 64); }

}  // namespace qs::test
