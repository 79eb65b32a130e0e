// SPDX-License-Identifier: MIT
//
// The frequencies of a picture: the magnitudes of its two-dimensional discrete Fourier transform.
#pragma once

#include <cstddef>
#include <vector>

#include "base/parallel.h"
#include "raster/scene/image.h"

namespace qs::train {

/// The discrete Fourier transform of one length: X[k] = sum over j of x[j] exp(-2 pi i j k /
/// length). Lengths other than powers of two are transformed by Bluestein's convolution (1970).
class Fourier {
 public:
  /// `length` is at least 1.
  explicit Fourier(std::size_t length);

  /// Complex numbers as two arrays.
  struct Values {
    std::vector<double> re, im;
  };

  /// Memory that is used again. Threads need their own.
  struct Work {
    Values values, other;
  };

  /// Replaces `length` values.
  void transform(double* re, double* im, Work& work) const;

 private:
  void transform_power_of_two(Values& values, Values& other) const;

  std::size_t length_, size_;  // size_: the power of two
  Values roots_;               // exp(-2 pi i k / size_) for k < size_ / 2
  Values chirp_, filter_;      // empty if length_ is a power of two
};

/// Magnitudes per frequency, row by row. Frequency 0 is in the middle: in row height / 2 and column
/// width / 2.
struct Spectrum {
  int width = 0, height = 0;
  std::vector<double> magnitudes;

  /// The sum over the channels red, green and blue.
  static Spectrum of(const Image& picture, ThreadPool& pool);

  /// Adds the spectrum of a picture of the same size.
  void add(const Spectrum& other);
};

/// Sums of a spectrum over the frequencies that remain when the picture is reduced.
class SpectrumSums {
 public:
  explicit SpectrumSums(const Spectrum& spectrum);

  double total() const { return table_.back(); }
  /// The sum over the rectangle around frequency 0 whose sides are 1 / scale of the whole; scale is
  /// at least 1.
  double within(double scale) const;

 private:
  double at(int x, int y) const {
    return table_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_ + 1) +
                  static_cast<std::size_t>(x)];
  }

  int width_, height_;
  std::vector<double> table_;  // sums over all rows above and all columns to the left
};

}  // namespace qs::train
