// SPDX-License-Identifier: MIT
#include "learn/step/cpu/loss.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>

#include "raster/kernel/ssim.h"
#include "raster/scene/image_metrics.h"

namespace qs::cpu::train {
namespace {

constexpr std::size_t kChannels = 3;

// The values of picture and photograph, channel by channel.
template <class Real>
struct ComparedValues {
  const Real* picture;
  const float* photograph;
  std::span<const std::uint8_t> mask;

  bool is_masked(std::size_t i) const { return !mask.empty() && mask[i / kChannels] == 0; }
};

// The sum of SSIM over the values that are not masked. Masked values count as outside of both
// pictures. `fields` become the arguments of LossGradient.
template <class Real>
double sum_ssim(const PictureRows& shape, const ComparedValues<Real>& values,
                SsimFields<Real>& fields) {
  fields.resize(shape.all_values());
  shape.for_rows([&](std::size_t y) {
    for (std::size_t i = y * shape.values(); i < (y + 1) * shape.values(); ++i) {
      const bool out = values.is_masked(i);
      fields.a[i] = out ? 0 : shown(values.picture[i]);
      fields.b[i] = out ? 0 : values.photograph[i];
    }
  });
  fields.find_moments(shape);
  const double sum = fields.sum_similarity(shape, {values.mask});
  fields.spread_derivatives(shape);
  return sum;
}

// Sums of the absolute and of the squared differences. Sets `d`, the gradient of the loss.
template <class Real>
std::pair<double, double> sum_differences(const PictureRows& shape,
                                          const ComparedValues<Real>& values,
                                          const LossGradient<Real>& gradient,
                                          const SsimFields<Real>& by, Real* d) {
  std::vector<double> squares(shape.height);
  const double absolute = shape.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t i = y * shape.values(); i < (y + 1) * shape.values(); ++i) {
      if (values.is_masked(i)) {
        d[i] = 0;
        continue;
      }
      const Real a = values.picture[i], b = values.photograph[i];
      const double difference = static_cast<double>(shown(a)) - static_cast<double>(b);
      sum += std::abs(static_cast<double>(shown(a) - b));
      squares[y] += difference * difference;
      d[i] = gradient.by(a, b, by.a[i], by.aa[i], by.ab[i]);
    }
    return sum;
  });
  return {absolute, std::accumulate(squares.begin(), squares.end(), 0.0)};
}

// Convolves `field` with the window, zeros outside. The window is symmetric, so this is also the
// adjoint that the gradient needs.
template <class Real>
void blur(const PictureRows& picture, std::vector<Real>& field, std::vector<Real>& rows) {
  static const auto kWindow = [] {
    const auto weights = ssim_window();
    std::array<Real, weights.size()> window{};
    for (std::size_t k = 0; k < window.size(); ++k) window[k] = static_cast<Real>(weights[k]);
    return window;
  }();
  const std::size_t channels = picture.channels, margin = kSsimRadius * channels;
  const std::size_t values = picture.values();
  // Convolve along the rows, into `rows`.
  rows.resize(field.size());
  picture.for_rows([&](std::size_t y) {
    std::vector<Real> padded(values + 2 * margin, 0);
    std::copy_n(field.begin() + static_cast<std::ptrdiff_t>(y * values), values,
                padded.begin() + static_cast<std::ptrdiff_t>(margin));
    Real* const out = &rows[y * values];
    std::fill_n(out, values, Real(0));
    for (std::size_t k = 0; k < kWindow.size(); ++k) {
      const Real* const in = &padded[k * channels];
      for (std::size_t i = 0; i < values; ++i) out[i] += kWindow[k] * in[i];
    }
  });
  // Convolve along the columns, back into `field`.
  picture.for_rows([&](std::size_t y) {
    Real* const out = &field[y * values];
    std::fill_n(out, values, Real(0));
    const std::size_t first = y < kSsimRadius ? kSsimRadius - y : 0;
    const std::size_t last = std::min(kWindow.size(), picture.height + kSsimRadius - y);
    for (std::size_t k = first; k < last; ++k) {
      const Real* const in = &rows[(y + k - kSsimRadius) * values];
      for (std::size_t i = 0; i < values; ++i) out[i] += kWindow[k] * in[i];
    }
  });
}

}  // namespace

template <class Real>
Loss compare(const LossInput<Real>& in, ThreadPool& pool, SsimFields<Real>& fields,
             std::vector<glm::vec<3, Real>>& d_color) {
  const PictureRows shape{static_cast<std::size_t>(in.width), static_cast<std::size_t>(in.height),
                          kChannels, pool};
  const std::size_t count = shape.all_values();
  assert(in.color.size() * kChannels == count && in.target.size() == in.color.size());
  assert(in.mask.empty() || in.mask.size() == in.color.size());
  const auto masked = std::ranges::count(in.mask, std::uint8_t{0});
  const auto total = static_cast<double>(count - static_cast<std::size_t>(masked) * kChannels);
  const ComparedValues<Real> values{&in.color[0][0], &in.target[0][0], in.mask};
  d_color.resize(in.color.size());

  const double ssim = sum_ssim(shape, values, fields);
  const auto [l1, squares] =
      sum_differences(shape, values, LossGradient<Real>::of(total), fields, &d_color[0][0]);
  return Loss::of_sums(l1, ssim, squares, total);
}

template decltype(compare<float>) compare<float>;
template decltype(compare<double>) compare<double>;

template <class Real>
void SsimFields<Real>::find_moments(const PictureRows& picture) {
  picture.for_rows([&](std::size_t y) {
    for (std::size_t i = y * picture.values(); i < (y + 1) * picture.values(); ++i) {
      aa[i] = a[i] * a[i];
      bb[i] = b[i] * b[i];
      ab[i] = a[i] * b[i];
    }
  });
  for (auto* field : {&a, &b, &aa, &bb, &ab}) blur(picture, *field, rows);
}

template <class Real>
double SsimFields<Real>::sum_similarity(const PictureRows& picture, const CountedPixels& counted) {
  return picture.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t k = 0; k < picture.values(); ++k) {
      const std::size_t i = y * picture.values() + k;
      if (!counted.at(picture, y, k)) {
        a[i] = aa[i] = ab[i] = 0;
        continue;
      }
      const auto s = Similarity<Real>::of(a[i], b[i], aa[i], bb[i], ab[i]);
      sum += static_cast<double>(s.value);
      a[i] = s.by_a;
      aa[i] = s.by_aa;
      ab[i] = s.by_ab;
    }
    return sum;
  });
}

template <class Real>
void SsimFields<Real>::spread_derivatives(const PictureRows& picture) {
  for (auto* field : {&a, &aa, &ab}) blur(picture, *field, rows);
}

template struct SsimFields<float>;
template struct SsimFields<double>;

}  // namespace qs::cpu::train
