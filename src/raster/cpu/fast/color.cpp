// SPDX-License-Identifier: MIT
#include <bit>

#include "raster/cpu/fast/survivors.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/color.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

/// Values of the real spherical harmonics in the directions (x, y, z).
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

/// Loads a vector of coefficients from either storage.
HWY_INLINE V load(D d, const float* values) { return hn::LoadU(d, values); }
HWY_INLINE V load(D d, const std::uint16_t* halves) {
  const hn::Rebind<hwy::float16_t, D> dh;
  const hn::Rebind<std::uint16_t, D> du;
  return hn::PromoteTo(d, hn::BitCast(dh, hn::LoadU(du, halves)));
}

/// Evaluates the colours of group `group` of block `index`.
template <class Value>
HWY_INLINE void color_group(const ColorInput& in, const Array<Value>& rest, const Block& block,
                            std::size_t index, std::size_t group, Colors& colors) {
  const D d;
  const int coefficients = sh_coefficient_count(in.degree);
  const std::size_t group_of_cloud = index * (kBlock / kGroup) + group;
  for (std::size_t lane = 0; lane < kGroup; lane += hn::Lanes(d)) {
    const std::size_t i = group * kGroup + lane;
    const V x = hn::Sub(hn::Load(d, block.x + i), hn::Set(d, in.view_position.x));
    const V y = hn::Sub(hn::Load(d, block.y + i), hn::Set(d, in.view_position.y));
    const V z = hn::Sub(hn::Load(d, block.z + i), hn::Set(d, in.view_position.z));
    const V length2 = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
    const V scale = hn::Div(hn::Set(d, 1.0f), hn::Sqrt(length2));
    V weights[16];
    harmonics(in.degree, hn::Mul(x, scale), hn::Mul(y, scale), hn::Mul(z, scale), weights);
    const float* base = in.sh.base.data() + group_of_cloud * 3 * kGroup + lane;
    const V half = hn::Set(d, 0.5f);
    V red = hn::MulAdd(weights[0], hn::LoadU(d, base), half);
    V green = hn::MulAdd(weights[0], hn::LoadU(d, base + kGroup), half);
    V blue = hn::MulAdd(weights[0], hn::LoadU(d, base + 2 * kGroup), half);
    std::size_t next = group_of_cloud * in.sh.rest_size() + lane;
    for (int k = 1; k < coefficients; ++k, next += 3 * kGroup) {
      const Value* value = rest.data() + next;
      red = hn::MulAdd(weights[k], load(d, value), red);
      green = hn::MulAdd(weights[k], load(d, value + kGroup), green);
      blue = hn::MulAdd(weights[k], load(d, value + 2 * kGroup), blue);
    }
    hn::Store(hn::Max(red, hn::Zero(d)), d, colors.red + i);
    hn::Store(hn::Max(green, hn::Zero(d)), d, colors.green + i);
    hn::Store(hn::Max(blue, hn::Zero(d)), d, colors.blue + i);
  }
}

void color_block(const ColorInput& in, const Block& block, std::size_t index,
                 const Survivors& survivors, Colors& colors) {
  std::uint32_t wanted = 0;
  for (std::size_t k = 0; k < survivors.count; ++k) wanted |= 1u << survivors.lane[k] / kGroup;
  for (; wanted != 0; wanted &= wanted - 1) {
    const auto group = static_cast<std::size_t>(std::countr_zero(wanted));
    if (in.sh.rest.empty()) {
      color_group(in, in.sh.halves, block, index, group, colors);
    } else {
      color_group(in, in.sh.rest, block, index, group, colors);
    }
  }
}

bool convert(const float* values, std::size_t count, std::uint16_t* halves) {
  const D d;
  const hn::Rebind<hwy::float16_t, D> dh;
  const hn::Rebind<std::uint16_t, D> du;
  const auto largest = hn::Set(d, 65504.0f);
  bool exact = true;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto value = hn::LoadU(d, values + i);
    const auto half = hn::DemoteTo(dh, value);
    const auto back = hn::PromoteTo(d, half);
    const auto equal = hn::And(hn::Eq(back, value), hn::Le(hn::Abs(value), largest));
    exact = exact && hn::AllTrue(d, equal);
    hn::StoreU(hn::BitCast(du, half), du, halves + i);
  }
  return exact;
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(color_block);
HWY_EXPORT(convert);

void color(const ColorInput& in, const Block& block, std::size_t index, const Survivors& survivors,
           Colors& colors) {
  HWY_DYNAMIC_DISPATCH(color_block)(in, block, index, survivors, colors);
}

bool to_halves(const float* values, std::size_t count, std::uint16_t* halves) {
  return HWY_DYNAMIC_DISPATCH(convert)(values, count, halves);
}

}  // namespace qs::cpu::fast
#endif
