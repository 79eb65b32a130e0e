// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/records.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/records.cpp"
#include "raster/cpu/fast/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

/// Prefetch distance in records. They are written at the speed of the memory.
constexpr std::size_t kPrefetch = 32;

/// The members of records that need divisions and roots, one array per value.
struct alignas(64) Shapes {
  float log2_256_opacity[Survivors::kRoom];
  float along[Survivors::kRoom], slope[Survivors::kRoom];
  float height[Survivors::kRoom], scale[Survivors::kRoom];

  HWY_INLINE explicit Shapes(const Survivors& s) {
    constexpr float kWider = 1.0005f;  // more than the error of a root in batch.cpp
    const D d;
    const V falloff = hn::Set(d, -kLog2OfFalloff);
    for (std::size_t k = 0; k < s.count; k += hn::Lanes(d)) {
      const V xx = hn::Load(d, s.xx + k);
      const V root = hn::Sqrt(hn::Mul(falloff, hn::Load(d, s.conic_c + k)));
      hn::Store(hn::Add(hn::Load(d, s.log2_opacity + k), hn::Set(d, 8.0f)), d,
                log2_256_opacity + k);
      hn::Store(hn::Div(falloff, xx), d, along + k);
      hn::Store(hn::Div(hn::Load(d, s.xy + k), xx), d, slope + k);
      hn::Store(hn::Div(hn::Set(d, kWider), root), d, height + k);
      hn::Store(root, d, scale + k);
    }
  }
};

void make_all_records(const Survivors& s, const Colors& colors, Record* records) {
  const Shapes shapes(s);
  for (std::size_t k = 0; k < s.count; ++k) {
    const std::uint32_t lane = s.lane[k];
    Record& record = records[k];
    __builtin_prefetch(records + k + kPrefetch, 1);
    record.mean_x = s.mean_x[k];
    record.mean_y = s.mean_y[k];
    record.log2_256_opacity = shapes.log2_256_opacity[k];
    record.along = shapes.along[k];
    record.slope = shapes.slope[k];
    record.height = shapes.height[k];
    record.scale = shapes.scale[k];
    record.red = colors.red[lane];
    record.green = colors.green[lane];
    record.blue = colors.blue[lane];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(make_all_records);

void make_records(const Survivors& survivors, const Colors& colors, Record* records) {
  HWY_DYNAMIC_DISPATCH(make_all_records)(survivors, colors, records);
}

}  // namespace qs::cpu::fast
#endif
