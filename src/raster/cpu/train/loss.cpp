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

}  // namespace

template <class Real>
Loss compare(int width, int height, std::span<const glm::vec<3, Real>> color,
             std::span<const glm::vec3> target, ThreadPool& pool, LossScratch<Real>& scratch,
             std::vector<glm::vec<3, Real>>& d_color, std::span<const std::uint8_t> mask) {
  const Shape shape{static_cast<std::size_t>(width) * kChannels, static_cast<std::size_t>(height),
                    pool};
  const std::size_t values = shape.values, count = values * shape.height;
  assert(color.size() * kChannels == count && target.size() == color.size());
  assert(mask.empty() || mask.size() == color.size());
  const auto is_masked = [&](std::size_t i) { return !mask.empty() && mask[i / kChannels] == 0; };
  const auto masked = std::count(mask.begin(), mask.end(), std::uint8_t{0});
  d_color.resize(color.size());
  const Real* const a = &color[0][0];
  const float* const b = &target[0][0];
  Real* const d = &d_color[0][0];
  std::vector<Real>&mean_a = scratch.fields[0], &mean_b = scratch.fields[1],
  &mean_aa = scratch.fields[2], &mean_bb = scratch.fields[3], &mean_ab = scratch.fields[4];
  for (auto& field : scratch.fields) field.resize(count);

  shape.for_rows([&](std::size_t y) {
    for (std::size_t i = y * values; i < (y + 1) * values; ++i) {
      const bool out = is_masked(i);
      const Real va = out ? 0 : shown(a[i]), vb = out ? 0 : b[i];
      mean_a[i] = va;
      mean_b[i] = vb;
      mean_aa[i] = va * va;
      mean_bb[i] = vb * vb;
      mean_ab[i] = va * vb;
    }
  });
  for (auto& field : scratch.fields) blur(shape, field, scratch.rows);

  const auto total = static_cast<double>(count - static_cast<std::size_t>(masked) * kChannels);
  // The derivatives replace the moments.
  const double ssim = shape.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t i = y * values; i < (y + 1) * values; ++i) {
      if (is_masked(i)) {
        mean_a[i] = mean_aa[i] = mean_ab[i] = 0;
        continue;
      }
      const auto s = Similarity<Real>::of(mean_a[i], mean_b[i], mean_aa[i], mean_bb[i], mean_ab[i]);
      sum += static_cast<double>(s.value);
      mean_a[i] = s.by_a;
      mean_aa[i] = s.by_aa;
      mean_ab[i] = s.by_ab;
    }
    return sum;
  });
  for (auto* field : {&mean_a, &mean_aa, &mean_ab}) blur(shape, *field, scratch.rows);

  const auto gradient = LossGradient<Real>::of(total);
  const double l1 = shape.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t i = y * values; i < (y + 1) * values; ++i) {
      if (is_masked(i)) {
        d[i] = 0;
        continue;
      }
      const Real vb = b[i];
      sum += std::abs(static_cast<double>(shown(a[i]) - vb));
      d[i] = gradient.by(a[i], vb, mean_a[i], mean_aa[i], mean_ab[i]);
    }
    return sum;
  });
  const double squared_error = shape.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t i = y * values; i < (y + 1) * values; ++i) {
      if (is_masked(i)) continue;
      const double difference = static_cast<double>(shown(a[i])) - static_cast<double>(b[i]);
      sum += difference * difference;
    }
    return sum;
  });
  return Loss::of_sums(l1, ssim, squared_error, total);
}

template Loss compare(int, int, std::span<const glm::vec3>, std::span<const glm::vec3>, ThreadPool&,
                      LossScratch<float>&, std::vector<glm::vec3>&, std::span<const std::uint8_t>);
template Loss compare(int, int, std::span<const glm::dvec3>, std::span<const glm::vec3>,
                      ThreadPool&, LossScratch<double>&, std::vector<glm::dvec3>&,
                      std::span<const std::uint8_t>);

}  // namespace qs::cpu::train
