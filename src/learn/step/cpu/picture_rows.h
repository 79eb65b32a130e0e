// SPDX-License-Identifier: MIT
//
// Loops over the rows of a picture, whose values are stored pixel by pixel.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

#include "base/parallel.h"

namespace qs::cpu::train {

struct PictureRows {
  std::size_t width, height, channels;
  ThreadPool& pool;

  /// Values of a row.
  std::size_t values() const { return width * channels; }
  std::size_t all_values() const { return values() * height; }

  /// Runs each(y) for every row in parallel.
  template <class Each>
  void for_rows(const Each& each) const {
    pool.for_each(height, 8, each);
  }

  /// Sum of row_sum(y); the order of summing is fixed.
  template <class RowSum>
  double sum_of_rows(const RowSum& row_sum) const {
    std::vector<double> sums(height);
    for_rows([&](std::size_t y) { sums[y] = row_sum(y); });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
  }
};

}  // namespace qs::cpu::train
