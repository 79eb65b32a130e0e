// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/color.h"

#include "raster/scene/gaussian_cloud.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/color.cpp"
#include "raster/cpu/fast/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;

/// Values of the real harmonics in the directions of one vector of Gaussians; weights[0] is
/// constant.
HWY_INLINE void harmonics(int degree, V x, V y, V z, V* weights) {
  const D d;
  const auto c = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<float>(value)); };
  weights[0] = c(kSh0);
  if (degree < 1) return;
  weights[1] = hn::Mul(c(-kSh1), y);
  weights[2] = hn::Mul(c(kSh1), z);
  weights[3] = hn::Mul(c(-kSh1), x);
  if (degree < 2) return;
  const V xx = hn::Mul(x, x), yy = hn::Mul(y, y), zz = hn::Mul(z, z), two_zz = hn::Add(zz, zz);
  const V difference = hn::Sub(xx, yy);
  weights[4] = hn::Mul(c(kSh2A), hn::Mul(x, y));
  weights[5] = hn::Mul(c(-kSh2A), hn::Mul(y, z));
  weights[6] = hn::Mul(c(kSh2B), hn::Sub(hn::Sub(two_zz, xx), yy));
  weights[7] = hn::Mul(c(-kSh2A), hn::Mul(x, z));
  weights[8] = hn::Mul(c(kSh2C), difference);
  if (degree < 3) return;
  const V three_xx = hn::Mul(c(3), xx), three_yy = hn::Mul(c(3), yy);
  const V four = hn::Sub(hn::Sub(hn::Add(two_zz, two_zz), xx), yy);
  weights[9] = hn::Mul(c(-kSh3A), hn::Mul(y, hn::Sub(three_xx, yy)));
  weights[10] = hn::Mul(c(kSh3B), hn::Mul(hn::Mul(x, y), z));
  weights[11] = hn::Mul(c(-kSh3C), hn::Mul(four, y));
  weights[12] = hn::Mul(c(kSh3D), hn::Mul(z, hn::Sub(hn::Sub(two_zz, three_xx), three_yy)));
  weights[13] = hn::Mul(c(-kSh3C), hn::Mul(four, x));
  weights[14] = hn::Mul(c(kSh3E), hn::Mul(z, difference));
  weights[15] = hn::Mul(c(-kSh3A), hn::Mul(x, hn::Sub(xx, three_yy)));
}

void color_block(const Harmonics& sh, glm::vec3 view_position, const glm::vec3* positions,
                 Survivors& s) {
  const D d;
  const DI di;
  const int stride = 3 * sh_coefficient_count(sh.stored_degree);
  const int coefficients = sh_coefficient_count(sh.degree);
  // Planes are read whole: what lies behind the last survivor must be an index of the cloud too.
  for (std::size_t k = s.count; k % hn::Lanes(d) != 0; ++k) s.gaussian[k] = s.gaussian[0];
  // Offsets from the first Gaussian of the block fit into 32 bits, those of large clouds do not.
  const float* values =
      sh.values + static_cast<std::size_t>(s.gaussian[0]) * static_cast<std::size_t>(stride);
  const float* xyz = &positions[s.gaussian[0]].x;
  const auto first = hn::Set(di, static_cast<std::int32_t>(s.gaussian[0]));
  const hn::RebindToUnsigned<D> du;
  for (std::size_t k = 0; k < s.count; k += hn::Lanes(d)) {
    const auto local = hn::Sub(hn::BitCast(di, hn::Load(du, s.gaussian + k)), first);
    const auto at = hn::Mul(local, hn::Set(di, 3));
    V x = hn::Sub(hn::GatherIndex(d, xyz, at), hn::Set(d, view_position.x));
    V y = hn::Sub(hn::GatherIndex(d, xyz + 1, at), hn::Set(d, view_position.y));
    V z = hn::Sub(hn::GatherIndex(d, xyz + 2, at), hn::Set(d, view_position.z));
    const V length2 = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
    const V scale = hn::Div(hn::Set(d, 1.0f), hn::Sqrt(length2));
    V weights[16];
    harmonics(sh.degree, hn::Mul(x, scale), hn::Mul(y, scale), hn::Mul(z, scale), weights);
    const auto from = hn::Mul(local, hn::Set(di, stride));
    V red = hn::Set(d, 0.5f), green = red, blue = red;
    for (int i = 0; i < coefficients; ++i) {
      red = hn::MulAdd(weights[i], hn::GatherIndex(d, values + 3 * i, from), red);
      green = hn::MulAdd(weights[i], hn::GatherIndex(d, values + 3 * i + 1, from), green);
      blue = hn::MulAdd(weights[i], hn::GatherIndex(d, values + 3 * i + 2, from), blue);
    }
    hn::Store(hn::Max(red, hn::Zero(d)), d, s.red + k);
    hn::Store(hn::Max(green, hn::Zero(d)), d, s.green + k);
    hn::Store(hn::Max(blue, hn::Zero(d)), d, s.blue + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(color_block);

void color(const Harmonics& sh, glm::vec3 view_position, const glm::vec3* positions,
           Survivors& survivors) {
  if (survivors.count == 0) return;
  HWY_DYNAMIC_DISPATCH(color_block)(sh, view_position, positions, survivors);
}

}  // namespace qs::cpu::fast
#endif
