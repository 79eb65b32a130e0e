// SPDX-License-Identifier: MIT
//
// The colour field of a Compact-3DGS model as plain data: a hash grid, which turns a position into
// features, and a network, which turns these and a direction into a colour.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "raster/kernel/color_field.h"

namespace qs {

/// The shape of a hash grid. All published models have the defaults.
struct GridShape {
  int levels = 16;
  int log2_entries = 19;  ///< a level has at most 2^log2_entries entries; 3..24
  int base = 16;          ///< resolution of the first level
  float growth = 1.447f;  ///< factor on the resolution from level to level
};

/// The levels of a grid, coarse to fine.
std::vector<GridLevel> grid_levels(const GridShape& shape);

/// Values of all levels: level by level, entry by entry, feature by feature.
std::size_t grid_value_count(const GridShape& shape);

/// A network of two hidden layers with ReLU and without biases. Inputs are the grid's features, the
/// direction's, and ones up to a multiple of 16; three of the 16 outputs are used. A matrix has a
/// row per output: (width, inputs), (width, width), (16, width), one after the other.
struct NetworkShape {
  int grid_inputs = 32;  ///< levels * kGridFeatures
  int width = 64;        ///< a multiple of 16

  int inputs() const { return (grid_inputs + kDirectionFeatures + 15) / 16 * 16; }
  /// Offsets of the second and the third matrix, and the number of all weights.
  std::size_t second() const { return size_of(width, inputs()); }
  std::size_t third() const { return second() + size_of(width, width); }
  std::size_t weight_count() const { return third() + size_of(kOutputs, width); }

  static constexpr int kOutputs = 16;

 private:
  static std::size_t size_of(int rows, int columns) {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  }
};

struct ColorField {
  GridShape grid;
  int width = 64;                  ///< width of the network
  std::vector<float> grid_values;  ///< grid_value_count(grid)
  std::vector<float> weights;      ///< network().weight_count()

  NetworkShape network() const { return {grid.levels * kGridFeatures, width}; }
};

}  // namespace qs
