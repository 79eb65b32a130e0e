// SPDX-License-Identifier: MIT
//
// Few values that stand for many: a codebook of 256 numbers, and a palette of vectors. Both are
// exact if there are no more different values than entries.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// 256 numbers in increasing order.
struct Codebook {
  std::array<float, 256> values{};

  /// The index of the number nearest to `value`.
  std::uint8_t nearest(float value) const;
};

/// The codebook with a small sum of squared errors for these values, which must be finite and at
/// least one. Sorts a sample of them.
Codebook make_codebook(const Array<float>& values);

/// Vectors of `dimensions` finite floats, `stride` floats apart.
struct VectorRows {
  const float* first = nullptr;
  std::size_t count = 0, stride = 0, dimensions = 0;

  const float* operator[](std::size_t i) const { return first + i * stride; }
};

struct Palette {
  std::size_t dimensions = 0;
  Array<float> values;               ///< the vectors, one after the other
  std::vector<std::uint32_t> label;  ///< of each row: the index of its vector

  std::size_t size() const { return values.size() / dimensions; }
};

/// At most `most` vectors for these rows: cells of rows with the largest squared errors are divided
/// at their means, along the axis of the largest variance, until there are enough cells; the
/// vectors are their means, the most frequent ones first.
Palette make_palette(const VectorRows& rows, std::size_t most, ThreadPool& pool,
                     const Progress& progress);

}  // namespace qs
