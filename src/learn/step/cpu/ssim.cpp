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
void find_moments(const PictureRows& picture, SsimFields<Real>& fields) {
  picture.for_rows([&](std::size_t y) {
    for (std::size_t i = y * picture.values(); i < (y + 1) * picture.values(); ++i) {
      const Real a = fields.a[i], b = fields.b[i];
      fields.aa[i] = a * a;
      fields.bb[i] = b * b;
      fields.ab[i] = a * b;
    }
  });
  for (auto* field : {&fields.a, &fields.b, &fields.aa, &fields.bb, &fields.ab})
    blur(picture, *field, fields.rows);
}

template <class Real>
double sum_similarity(const PictureRows& picture, const CountedPixels& counted,
                      SsimFields<Real>& fields) {
  return picture.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t k = 0; k < picture.values(); ++k) {
      const std::size_t i = y * picture.values() + k;
      if (!counted.at(picture, y, k)) {
        fields.a[i] = fields.aa[i] = fields.ab[i] = 0;
        continue;
      }
      const auto s =
          Similarity<Real>::of(fields.a[i], fields.b[i], fields.aa[i], fields.bb[i], fields.ab[i]);
      sum += static_cast<double>(s.value);
      fields.a[i] = s.by_a;
      fields.aa[i] = s.by_aa;
      fields.ab[i] = s.by_ab;
    }
    return sum;
  });
}

template <class Real>
void spread_derivatives(const PictureRows& picture, SsimFields<Real>& fields) {
  for (auto* field : {&fields.a, &fields.aa, &fields.ab}) blur(picture, *field, fields.rows);
}

template void find_moments(const PictureRows&, SsimFields<float>&);
template void find_moments(const PictureRows&, SsimFields<double>&);
template double sum_similarity(const PictureRows&, const CountedPixels&, SsimFields<float>&);
template double sum_similarity(const PictureRows&, const CountedPixels&, SsimFields<double>&);
template void spread_derivatives(const PictureRows&, SsimFields<float>&);
template void spread_derivatives(const PictureRows&, SsimFields<double>&);

}  // namespace qs::cpu::train
