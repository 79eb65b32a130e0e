// SPDX-License-Identifier: MIT
//
// The colour of a pixel or of a Gaussian with any number of channels. Numbers of channels are
// rounded up to a few sizes, for which the passes are compiled; further channels are 0.
#pragma once

#include <type_traits>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/hd.h"

namespace qs::diff {

template <class Real, int kCount>
struct Channels {
  Real values[kCount];

  QS_HD explicit Channels(Real value = 0) {
    for (Real& v : values) v = value;
  }
  QS_HD Real& operator[](int c) { return values[c]; }
  QS_HD const Real& operator[](int c) const { return values[c]; }

  QS_HD Channels& operator+=(const Channels& other) {
    for (int c = 0; c < kCount; ++c) values[c] += other[c];
    return *this;
  }
  QS_HD Channels& operator-=(const Channels& other) {
    for (int c = 0; c < kCount; ++c) values[c] -= other[c];
    return *this;
  }
  friend QS_HD Channels operator+(Channels a, const Channels& b) { return a += b; }
  friend QS_HD Channels operator-(Channels a, const Channels& b) { return a -= b; }
  friend QS_HD Channels operator*(Channels a, Real factor) {
    for (Real& v : a.values) v *= factor;
    return a;
  }
  friend QS_HD Channels operator*(Real factor, Channels a) { return a * factor; }
  friend QS_HD Channels operator/(Channels a, Real divisor) {
    for (Real& v : a.values) v /= divisor;
    return a;
  }
  friend QS_HD Real dot(const Channels& a, const Channels& b) {
    Real sum = a[0] * b[0];
    for (int c = 1; c < kCount; ++c) sum += a[c] * b[c];
    return sum;
  }
};

/// A colour of kCount channels.
template <class Real, int kCount>
using Color = std::conditional_t<kCount == 3, glm::vec<3, Real>, Channels<Real, kCount>>;

/// Calls f(std::integral_constant<int, size>{}) with the least size >= `channels`, 1..32.
template <class F>
decltype(auto) with_channels(int channels, F&& f) {
  if (channels == 3) return f(std::integral_constant<int, 3>{});
  if (channels <= 1) return f(std::integral_constant<int, 1>{});
  if (channels <= 4) return f(std::integral_constant<int, 4>{});
  if (channels <= 8) return f(std::integral_constant<int, 8>{});
  if (channels <= 16) return f(std::integral_constant<int, 16>{});
  return f(std::integral_constant<int, 32>{});
}

}  // namespace qs::diff
