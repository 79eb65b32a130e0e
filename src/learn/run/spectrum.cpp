// SPDX-License-Identifier: MIT
#include "learn/run/spectrum.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

namespace qs::train {
namespace {

void resize(Fourier::Values& values, std::size_t size) {
  values.re.resize(size);
  values.im.resize(size);
}

// exp(-i angle)
void set_root(Fourier::Values& values, std::size_t k, double angle) {
  values.re[k] = std::cos(angle);
  values.im[k] = -std::sin(angle);
}

/// A picture's complex numbers per pixel, row by row.
struct Plane {
  std::size_t width, height;
  Fourier::Values values;

  Plane(std::size_t w, std::size_t h) : width(w), height(h) { resize(values, w * h); }
};

void transform_rows(Plane& plane, ThreadPool& pool) {
  const Fourier fourier(plane.width);
  std::vector<Fourier::Work> work(static_cast<std::size_t>(pool.size()));
  pool.for_chunks(plane.height, 16, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t y = begin; y < end; ++y)
      fourier.transform(&plane.values.re[y * plane.width], &plane.values.im[y * plane.width],
                        work[static_cast<std::size_t>(worker)]);
  });
}

Plane transposed(const Plane& plane, ThreadPool& pool) {
  Plane result(plane.height, plane.width);
  constexpr std::size_t kRows = 16;
  pool.for_chunks(result.height, kRows, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t x = 0; x < result.width; ++x) {
      for (std::size_t y = begin; y < end; ++y) {
        result.values.re[y * result.width + x] = plane.values.re[x * plane.width + y];
        result.values.im[y * result.width + x] = plane.values.im[x * plane.width + y];
      }
    }
  });
  return result;
}

// The transform of real + i imaginary for two channels; transposed. `imaginary` < 0: zeros.
Plane transform_of(const Image& picture, int real, int imaginary, ThreadPool& pool) {
  Plane plane(static_cast<std::size_t>(picture.width), static_cast<std::size_t>(picture.height));
  for (std::size_t i = 0; i < plane.width * plane.height; ++i) {
    const float* const pixel = &picture.values[i * static_cast<std::size_t>(picture.channels)];
    plane.values.re[i] = static_cast<double>(pixel[real]);
    plane.values.im[i] = imaginary < 0 ? 0 : static_cast<double>(pixel[imaginary]);
  }
  transform_rows(plane, pool);
  Plane result = transposed(plane, pool);
  transform_rows(result, pool);
  return result;
}

// fft(a + i b) holds the transforms of two real pictures: with z = fft[k] and c = the conjugate of
// fft[-k], a's is (z + c) / 2 and b's is (z - c) / 2i. Adds both magnitudes per frequency.
void add_magnitudes(const Plane& plane, bool pair, Spectrum& spectrum, ThreadPool& pool) {
  const std::size_t columns = plane.height, rows = plane.width;  // the plane is transposed
  const auto& [re, im] = plane.values;
  pool.for_each(rows, 16, [&](std::size_t y) {
    const std::size_t to_row = (y + rows / 2) % rows;
    for (std::size_t x = 0; x < columns; ++x) {
      double& to = spectrum.magnitudes[to_row * columns + (x + columns / 2) % columns];
      const std::size_t z = x * rows + y;
      if (!pair) {
        to += std::sqrt(re[z] * re[z] + im[z] * im[z]);
        continue;
      }
      const std::size_t c = (columns - x) % columns * rows + (rows - y) % rows;
      const double a_re = re[z] + re[c], a_im = im[z] - im[c];
      const double b_re = re[z] - re[c], b_im = im[z] + im[c];
      to += 0.5 * (std::sqrt(a_re * a_re + a_im * a_im) + std::sqrt(b_re * b_re + b_im * b_im));
    }
  });
}

}  // namespace

Fourier::Fourier(std::size_t length)
    : length_(length), size_(std::has_single_bit(length) ? length : std::bit_ceil(2 * length - 1)) {
  assert(length > 0);
  resize(roots_, size_ / 2);
  for (std::size_t k = 0; k < size_ / 2; ++k)
    set_root(roots_, k, 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(size_));
  if (size_ == length_) return;
  // Bluestein: jk = (j^2 + k^2 - (k - j)^2) / 2 makes the transform a convolution with a chirp.
  resize(chirp_, length_);
  resize(filter_, size_);
  for (std::size_t j = 0; j < length_; ++j) {
    const double turns = static_cast<double>(j * j % (2 * length_)) / static_cast<double>(length_);
    set_root(chirp_, j, std::numbers::pi * turns);
    for (const std::size_t place : {j, (size_ - j) % size_}) {
      filter_.re[place] = chirp_.re[j];
      filter_.im[place] = -chirp_.im[j];
    }
  }
  Values other;
  transform_power_of_two(filter_, other);
}

// Stockham's algorithm (Cochran et al. 1967): every pass reads one array and writes the other.
void Fourier::transform_power_of_two(Values& values, Values& other) const {
  resize(other, size_);
  std::size_t stride = 1;
  for (std::size_t half = size_ / 2; half > 0; half /= 2, stride *= 2) {
    for (std::size_t p = 0; p < half; ++p) {
      const double w_re = roots_.re[p * stride], w_im = roots_.im[p * stride];
      const double *a_re = &values.re[stride * p], *a_im = &values.im[stride * p];
      const double *b_re = a_re + stride * half, *b_im = a_im + stride * half;
      double *to_re = &other.re[2 * stride * p], *to_im = &other.im[2 * stride * p];
      for (std::size_t q = 0; q < stride; ++q) {
        const double d_re = a_re[q] - b_re[q], d_im = a_im[q] - b_im[q];
        to_re[q] = a_re[q] + b_re[q];
        to_im[q] = a_im[q] + b_im[q];
        to_re[stride + q] = d_re * w_re - d_im * w_im;
        to_im[stride + q] = d_re * w_im + d_im * w_re;
      }
    }
    std::swap(values, other);
  }
}

void Fourier::transform(double* re, double* im, Work& work) const {
  auto& [values, other] = work;
  resize(values, size_);
  if (chirp_.re.empty()) {
    std::copy_n(re, length_, values.re.begin());
    std::copy_n(im, length_, values.im.begin());
    transform_power_of_two(values, other);
    std::copy_n(values.re.begin(), length_, re);
    std::copy_n(values.im.begin(), length_, im);
    return;
  }
  const auto& [chirp_re, chirp_im] = chirp_;
  for (std::size_t j = 0; j < length_; ++j) {
    values.re[j] = re[j] * chirp_re[j] - im[j] * chirp_im[j];
    values.im[j] = re[j] * chirp_im[j] + im[j] * chirp_re[j];
  }
  std::fill(values.re.begin() + static_cast<std::ptrdiff_t>(length_), values.re.end(), 0.0);
  std::fill(values.im.begin() + static_cast<std::ptrdiff_t>(length_), values.im.end(), 0.0);
  transform_power_of_two(values, other);
  // The inverse transform of z is the conjugate of the transform of z's conjugate, divided by size.
  for (std::size_t k = 0; k < size_; ++k) {
    const double z_re = values.re[k] * filter_.re[k] - values.im[k] * filter_.im[k];
    values.im[k] = -(values.re[k] * filter_.im[k] + values.im[k] * filter_.re[k]);
    values.re[k] = z_re;
  }
  transform_power_of_two(values, other);
  const double scale = 1 / static_cast<double>(size_);
  for (std::size_t k = 0; k < length_; ++k) {
    const double z_re = scale * values.re[k], z_im = -scale * values.im[k];
    re[k] = z_re * chirp_re[k] - z_im * chirp_im[k];
    im[k] = z_re * chirp_im[k] + z_im * chirp_re[k];
  }
}

Spectrum Spectrum::of(const Image& picture, ThreadPool& pool) {
  assert(picture.channels == 3);
  Spectrum spectrum{picture.width, picture.height, {}};
  spectrum.magnitudes.assign(picture.values.size() / 3, 0);
  add_magnitudes(transform_of(picture, 0, 1, pool), true, spectrum, pool);
  add_magnitudes(transform_of(picture, 2, -1, pool), false, spectrum, pool);
  return spectrum;
}

void Spectrum::add(const Spectrum& other) {
  assert(other.width == width && other.height == height);
  for (std::size_t i = 0; i < magnitudes.size(); ++i) magnitudes[i] += other.magnitudes[i];
}

SpectrumSums::SpectrumSums(const Spectrum& spectrum)
    : width_(spectrum.width), height_(spectrum.height) {
  const auto width = static_cast<std::size_t>(width_), height = static_cast<std::size_t>(height_);
  table_.assign((width + 1) * (height + 1), 0);
  for (std::size_t y = 0; y < height; ++y) {
    double row = 0;
    for (std::size_t x = 0; x < width; ++x) {
      row += spectrum.magnitudes[y * width + x];
      table_[(y + 1) * (width + 1) + x + 1] = table_[y * (width + 1) + x + 1] + row;
    }
  }
}

double SpectrumSums::within(double scale) const {
  const auto range = [scale](int size) {
    const int middle = (size + 1) / 2, half = static_cast<int>(size / scale) / 2;
    return std::pair(middle - half, middle + half);
  };
  const auto [left, right] = range(width_);
  const auto [top, bottom] = range(height_);
  return at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top);
}

}  // namespace qs::train
