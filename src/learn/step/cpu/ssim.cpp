// SPDX-License-Identifier: MIT
#include "learn/step/cpu/ssim.h"

#include <algorithm>
#include <array>

#include "raster/kernel/ssim.h"
#include "raster/scene/image_metrics.h"

namespace qs::cpu::train {
namespace {

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
