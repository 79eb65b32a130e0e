// SPDX-License-Identifier: MIT
#include "raster/cpu/train/loss.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

#include "raster/kernel/ssim.h"
#include "raster/scene/image_metrics.h"

namespace qs::cpu::train {
namespace {

constexpr int kChannels = 3;
constexpr std::size_t kRowGrain = 8;

// A picture of `values` numbers per row; runs each(y) for every row in parallel.
struct Shape {
  std::size_t values, height;
  ThreadPool& pool;

  template <class Each>
  void for_rows(const Each& each) const {
    pool.for_chunks(height, kRowGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t y = begin; y < end; ++y) each(y);
    });
  }

  // Sum of row_sum(y); the order of summing is fixed.
  template <class RowSum>
  double sum_of_rows(const RowSum& row_sum) const {
    std::vector<double> sums(height);
    for_rows([&](std::size_t y) { sums[y] = row_sum(y); });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
  }
};

// Convolves `field` with the window, zeros outside. The window is symmetric, so this is also the
// adjoint that the gradient needs.
template <class Real>
void blur(const Shape& shape, std::vector<Real>& field, std::vector<Real>& rows) {
  static const auto kWindow = [] {
    const auto weights = ssim_window();
    std::array<Real, weights.size()> window{};
    for (std::size_t k = 0; k < window.size(); ++k) window[k] = static_cast<Real>(weights[k]);
    return window;
  }();
  constexpr std::size_t kMargin = kSsimRadius * kChannels;
  const std::size_t values = shape.values;
  // Convolve along the rows, into `rows`.
  rows.resize(field.size());
  shape.for_rows([&](std::size_t y) {
    std::vector<Real> padded(values + 2 * kMargin, 0);
    std::copy_n(field.begin() + static_cast<std::ptrdiff_t>(y * values), values,
                padded.begin() + kMargin);
    Real* const out = &rows[y * values];
    std::fill_n(out, values, Real(0));
    for (std::size_t k = 0; k < kWindow.size(); ++k) {
      const Real* const in = &padded[k * kChannels];
      for (std::size_t i = 0; i < values; ++i) out[i] += kWindow[k] * in[i];
    }
  });
  // Convolve along the columns, back into `field`.
  shape.for_rows([&](std::size_t y) {
    Real* const out = &field[y * values];
    std::fill_n(out, values, Real(0));
    const std::size_t first = y < kSsimRadius ? kSsimRadius - y : 0;
    const std::size_t last = std::min(kWindow.size(), shape.height + kSsimRadius - y);
    for (std::size_t k = first; k < last; ++k) {
      const Real* const in = &rows[(y + k - kSsimRadius) * values];
      for (std::size_t i = 0; i < values; ++i) out[i] += kWindow[k] * in[i];
    }
  });
}

// The values of picture and photograph, channel by channel.
template <class Real>
struct ComparedValues {
  const Real* picture;
  const float* photograph;
  std::span<const std::uint8_t> mask;

  bool is_masked(std::size_t i) const { return !mask.empty() && mask[i / kChannels] == 0; }
};

// The moments of the values under the window, zeros where they are masked.
template <class Real>
void find_moments(const Shape& shape, const ComparedValues<Real>& values,
                  LossScratch<Real>& moments) {
  shape.for_rows([&](std::size_t y) {
    for (std::size_t i = y * shape.values; i < (y + 1) * shape.values; ++i) {
      const bool out = values.is_masked(i);
      const Real a = out ? 0 : shown(values.picture[i]), b = out ? 0 : values.photograph[i];
      moments.a[i] = a;
      moments.b[i] = b;
      moments.aa[i] = a * a;
      moments.bb[i] = b * b;
      moments.ab[i] = a * b;
    }
  });
  for (auto* field : {&moments.a, &moments.b, &moments.aa, &moments.bb, &moments.ab})
    blur(shape, *field, moments.rows);
}

// Sum of SSIM. Its derivatives by the picture's values replace the moments that contain them.
template <class Real>
double sum_similarity(const Shape& shape, const ComparedValues<Real>& values,
                      LossScratch<Real>& moments) {
  const double sum = shape.sum_of_rows([&](std::size_t y) {
    double of_row = 0;
    for (std::size_t i = y * shape.values; i < (y + 1) * shape.values; ++i) {
      if (values.is_masked(i)) {
        moments.a[i] = moments.aa[i] = moments.ab[i] = 0;
        continue;
      }
      const auto s = Similarity<Real>::of(moments.a[i], moments.b[i], moments.aa[i], moments.bb[i],
                                          moments.ab[i]);
      of_row += static_cast<double>(s.value);
      moments.a[i] = s.by_a;
      moments.aa[i] = s.by_aa;
      moments.ab[i] = s.by_ab;
    }
    return of_row;
  });
  for (auto* field : {&moments.a, &moments.aa, &moments.ab}) blur(shape, *field, moments.rows);
  return sum;
}

// Sum of absolute differences. Sets `d`, the gradient of the loss.
template <class Real>
double sum_l1(const Shape& shape, const ComparedValues<Real>& values,
              const LossGradient<Real>& gradient, const LossScratch<Real>& by, Real* d) {
  return shape.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t i = y * shape.values; i < (y + 1) * shape.values; ++i) {
      if (values.is_masked(i)) {
        d[i] = 0;
        continue;
      }
      const Real a = values.picture[i], b = values.photograph[i];
      sum += std::abs(static_cast<double>(shown(a) - b));
      d[i] = gradient.by(a, b, by.a[i], by.aa[i], by.ab[i]);
    }
    return sum;
  });
}

template <class Real>
double sum_squared_error(const Shape& shape, const ComparedValues<Real>& values) {
  return shape.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t i = y * shape.values; i < (y + 1) * shape.values; ++i) {
      if (values.is_masked(i)) continue;
      const double difference =
          static_cast<double>(shown(values.picture[i])) - static_cast<double>(values.photograph[i]);
      sum += difference * difference;
    }
    return sum;
  });
}

}  // namespace

template <class Real>
Loss compare(const LossInput<Real>& in, ThreadPool& pool, LossScratch<Real>& scratch,
             std::vector<glm::vec<3, Real>>& d_color) {
  const Shape shape{static_cast<std::size_t>(in.width) * kChannels,
                    static_cast<std::size_t>(in.height), pool};
  const std::size_t count = shape.values * shape.height;
  assert(in.color.size() * kChannels == count && in.target.size() == in.color.size());
  assert(in.mask.empty() || in.mask.size() == in.color.size());
  const auto masked = std::count(in.mask.begin(), in.mask.end(), std::uint8_t{0});
  const auto total = static_cast<double>(count - static_cast<std::size_t>(masked) * kChannels);
  const ComparedValues<Real> values{&in.color[0][0], &in.target[0][0], in.mask};
  d_color.resize(in.color.size());
  for (auto* field : {&scratch.a, &scratch.b, &scratch.aa, &scratch.bb, &scratch.ab})
    field->resize(count);

  find_moments(shape, values, scratch);
  const double ssim = sum_similarity(shape, values, scratch);
  const double l1 = sum_l1(shape, values, LossGradient<Real>::of(total), scratch, &d_color[0][0]);
  return Loss::of_sums(l1, ssim, sum_squared_error(shape, values), total);
}

template Loss compare(const LossInput<float>&, ThreadPool&, LossScratch<float>&,
                      std::vector<glm::vec3>&);
template Loss compare(const LossInput<double>&, ThreadPool&, LossScratch<double>&,
                      std::vector<glm::dvec3>&);

}  // namespace qs::cpu::train
