// SPDX-License-Identifier: MIT
//
// Resampling of pictures, with weights that are the same for all rows and for all columns.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/parallel.h"

namespace qs {

/// A new value of an axis: the sum of weights[k] times old value first + k.
struct Taps {
  int first = 0;
  std::vector<double> weights;
};

/// Fills `out` with new values, row by row: round() of sums in double precision. `pixels` has rows
/// of `width` pixels with `channels` interleaved values.
template <class Value, class Round>
void resample(std::span<const Value> pixels, int width, int channels,
              const std::vector<Taps>& across, const std::vector<Taps>& down, ThreadPool& pool,
              const Round& round, Value* out) {
  const auto values = static_cast<std::size_t>(channels);
  const auto row_values = static_cast<std::size_t>(width) * values;
  pool.for_each(down.size(), 8, [&](std::size_t y) {
    std::vector<double> row(row_values, 0);
    for (std::size_t k = 0; k < down[y].weights.size(); ++k) {
      const Value* const old = &pixels[(static_cast<std::size_t>(down[y].first) + k) * row_values];
      for (std::size_t i = 0; i < row_values; ++i)
        row[i] += down[y].weights[k] * static_cast<double>(old[i]);
    }
    Value* to = out + y * across.size() * values;
    for (const Taps& taps : across) {
      const double* const first = &row[static_cast<std::size_t>(taps.first) * values];
      for (std::size_t c = 0; c < values; ++c) {
        double sum = 0;
        for (std::size_t k = 0; k < taps.weights.size(); ++k)
          sum += taps.weights[k] * first[k * values + c];
        *to++ = round(sum);
      }
    }
  });
}

}  // namespace qs
