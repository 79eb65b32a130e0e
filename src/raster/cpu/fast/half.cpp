// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/half.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/half.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

bool convert(const float* values, std::size_t count, std::uint16_t* halves) {
  const hn::CappedTag<float, 16> d;
  const hn::Rebind<hwy::float16_t, decltype(d)> dh;
  const hn::Rebind<std::uint16_t, decltype(d)> du;
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

HWY_EXPORT(convert);

bool to_halves(const float* values, std::size_t count, std::uint16_t* halves) {
  return HWY_DYNAMIC_DISPATCH(convert)(values, count, halves);
}

}  // namespace qs::cpu::fast
#endif
