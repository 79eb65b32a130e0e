// SPDX-License-Identifier: MIT
//
// The loss of kernel/loss.h with its gradient. SSIM of the pictures a and b is as kernel/ssim.h
// defines it, with its derivatives by the values of a. Its three steps work on fields in place:
// find_moments(), sum_similarity(), spread_derivatives().
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "learn/gradient/loss.h"

namespace qs::cpu::train {

/// Loops over the rows of a picture, whose values are stored pixel by pixel.
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

/// The pixels whose SSIM counts. Windows reach all pixels.
struct CountedPixels {
  std::span<const std::uint8_t> mask = {};  ///< per pixel, 0: does not count; empty: all count
  std::size_t margin = 0;                   ///< pixels nearer to the border do not count

  /// True if a value of row y counts; `i` is an index into the row.
  bool at(const PictureRows& picture, std::size_t y, std::size_t i) const {
    if (margin == 0 && mask.empty()) return true;
    const std::size_t x = i / picture.channels;
    return x >= margin && x + margin < picture.width && y >= margin &&
           y + margin < picture.height && (mask.empty() || mask[y * picture.width + x] != 0);
  }
};

/// A number per value of the picture. The next picture uses the memory again.
template <class Real>
struct SsimFields {
  std::vector<Real> a, b;        ///< values, then their means in the window; a: then derivatives
  std::vector<Real> aa, bb, ab;  ///< means of products; aa, ab: then derivatives
  std::vector<Real> rows;        ///< memory of the convolution

  void resize(std::size_t values) {
    for (auto* field : {&a, &b, &aa, &bb, &ab}) field->resize(values);
  }

  /// From the values in a and b to the moments in the window, with zeros outside of the picture.
  void find_moments(const PictureRows& picture);

  /// The sum of SSIM over all values that count. a, aa and ab become its derivatives by these
  /// moments.
  double sum_similarity(const PictureRows& picture, const CountedPixels& counted);

  /// Sums the derivatives over the windows that reach a value: the arguments of similarity_by().
  void spread_derivatives(const PictureRows& picture);
};

/// A picture and the photograph that it is compared with, both per pixel, row by row.
template <class Real>
struct LossInput {
  int width, height;
  std::span<const glm::vec<3, Real>> color;
  std::span<const glm::vec3> target;
  /// Pixels whose value is 0 are left out and have no derivative. Without a mask all pixels count,
  /// with a mask at least one pixel must count.
  std::span<const std::uint8_t> mask = {};
};

/// Sets `d_color` to the derivatives of the total by the picture's colours. A channel equal to the
/// target's has no derivative of L1. The next step uses the memory of `fields` again.
template <class Real>
Loss compare(const LossInput<Real>& in, ThreadPool& pool, SsimFields<Real>& fields,
             std::vector<glm::vec<3, Real>>& d_color);

}  // namespace qs::cpu::train
