// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/blend_tile.h"

#include <algorithm>

#include "raster/cpu/fast/batch.h"
#include "raster/cpu/fast/tile.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/blend_tile.cpp"
#include "raster/cpu/fast/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kCellPixels>;
using DU = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

/// Polynomial for 2^x on [0, 1): coefficients of x^0 to x^5. A minimax fit with a relative error
/// below 1e-7.
[[maybe_unused]] constexpr float kFloorExp2C0 = 0.99999994f;
[[maybe_unused]] constexpr float kFloorExp2C1 = 0.69315308f;
[[maybe_unused]] constexpr float kFloorExp2C2 = 0.24015361f;
[[maybe_unused]] constexpr float kFloorExp2C3 = 0.055826318f;
[[maybe_unused]] constexpr float kFloorExp2C4 = 0.0089893397f;
[[maybe_unused]] constexpr float kFloorExp2C5 = 0.0018775767f;

/// Entries whose alphas are computed side by side: each alpha is a chain of dependent instructions,
/// too long for a CPU to overlap the chains by itself.
constexpr std::uint32_t kChains = HWY_MAX_BYTES >= 64 ? 4 : 2;
static_assert(Batch::kMultiple % kChains == 0);

/// Calls step(0), step(1), ...
template <class Step>
HWY_INLINE void each(Step&& step) {
  for (std::uint32_t j = 0; j < kChains; ++j) step(j);
}

#if HWY_TARGET == HWY_AVX3

/// 2^x, relative error below 2e-7. AVX-512 has instructions for the fraction and for the scaling;
/// Highway 1.0 does not offer them.
HWY_INLINE void exp2_polynomial(V (&x)[kChains]) {
  constexpr int kMinusFloor = 0x09;
  const D d;
  V fraction[kChains], p[kChains];
  each([&](std::uint32_t j) HWY_ATTR { fraction[j] = V{_mm512_reduce_ps(x[j].raw, kMinusFloor)}; });
  each([&](std::uint32_t j) HWY_ATTR {
    p[j] = hn::MulAdd(hn::Set(d, kFloorExp2C5), fraction[j], hn::Set(d, kFloorExp2C4));
  });
  for (const float c : {kFloorExp2C3, kFloorExp2C2, kFloorExp2C1, kFloorExp2C0}) {
    const V constant = hn::Set(d, c);
    each([&](std::uint32_t j) HWY_ATTR { p[j] = hn::MulAdd(p[j], fraction[j], constant); });
  }
  each([&](std::uint32_t j) HWY_ATTR { x[j] = V{_mm512_scalef_ps(p[j].raw, x[j].raw)}; });
}

#else

/// kernel/blend.h's exp2_polynomial() for x > -126; below, the result has no meaning.
HWY_INLINE void exp2_polynomial(V (&x)[kChains]) {
  const D d;
  const DU du;
  const V round = hn::Set(d, kRoundToInteger);
  V shifted[kChains], p[kChains];
  each([&](std::uint32_t j) HWY_ATTR { shifted[j] = hn::Add(x[j], round); });
  each([&](std::uint32_t j) HWY_ATTR { p[j] = hn::Sub(shifted[j], round); });
  each([&](std::uint32_t j) HWY_ATTR { x[j] = hn::Sub(x[j], p[j]); });
  each([&](std::uint32_t j)
           HWY_ATTR { p[j] = hn::MulAdd(hn::Set(d, kExp2C5), x[j], hn::Set(d, kExp2C4)); });
  for (const float c : {kExp2C3, kExp2C2, kExp2C1, 1.0f}) {
    const V constant = hn::Set(d, c);
    each([&](std::uint32_t j) HWY_ATTR { p[j] = hn::MulAdd(p[j], x[j], constant); });
  }
  each([&](std::uint32_t j) HWY_ATTR {
    const auto exponent = hn::ShiftLeft<23>(hn::BitCast(du, shifted[j]));
    x[j] = hn::BitCast(d, hn::Add(hn::BitCast(du, p[j]), exponent));
  });
}

#endif

/// The position of a vector of pixels, relative to the tile's middle.
struct Place {
  V x, y, xx, xy, yy;

  /// Pixels [at, at + kLanes) of a cell.
  HWY_INLINE Place(int cell, int at) {
    const D d;
    const DU du;
    const auto pixel = hn::Iota(du, static_cast<std::uint32_t>(at));
    const auto column = hn::And(pixel, hn::Set(du, kCellSide - 1));
    const auto row = hn::ShiftRight<2>(pixel);
    static_assert(kCellSide == 4);
    const auto from_middle = [d](auto lane, int cells) HWY_ATTR {
      const hn::RebindToSigned<D> di;
      return hn::Add(hn::ConvertTo(d, hn::BitCast(di, lane)),
                     hn::Set(d, float(cells * kCellSide) - 0.5f * (kTileSize - 1)));
    };
    x = from_middle(column, cell % kCellsInRow);
    y = from_middle(row, cell / kCellsInRow);
    xx = hn::Mul(x, x);
    xy = hn::Mul(x, y);
    yy = hn::Mul(y, y);
  }
};

/// A vector of pixels, loaded from a cell.
struct Pixels {
  V transmittance, red, green, blue;

  HWY_INLINE Pixels(const Cell& cell, int at) {
    const D d;
    transmittance = hn::Load(d, cell.transmittance + at);
    red = hn::Load(d, cell.red + at);
    green = hn::Load(d, cell.green + at);
    blue = hn::Load(d, cell.blue + at);
  }

  HWY_INLINE void store(Cell& cell, int at) const {
    const D d;
    hn::Store(transmittance, d, cell.transmittance + at);
    hn::Store(red, d, cell.red + at);
    hn::Store(green, d, cell.green + at);
    hn::Store(blue, d, cell.blue + at);
  }

  HWY_INLINE M live() const { return hn::Gt(transmittance, hn::Zero(D())); }

  /// Adds entry k.
  HWY_INLINE void add(const Batch& batch, std::uint32_t k, V weight) {
    const D d;
    red = hn::MulAdd(hn::Set(d, batch.red[k]), weight, red);
    green = hn::MulAdd(hn::Set(d, batch.green[k]), weight, green);
    blue = hn::MulAdd(hn::Set(d, batch.blue[k]), weight, blue);
  }
};

/// Computes the alphas of kChains entries; 0 below 1/255. kClamps: an entry has a limit.
template <bool kClamps>
HWY_INLINE void alphas_of(const Batch& batch, const std::uint32_t* entries, const Place& place,
                          V (&alpha)[kChains], M (&counts)[kChains]) {
  const D d;
  const auto add = [&](const float* factors, V variable) HWY_ATTR {
    each([&](std::uint32_t j) HWY_ATTR {
      alpha[j] = hn::MulAdd(hn::Set(d, factors[entries[j]]), variable, alpha[j]);
    });
  };
  each([&](std::uint32_t j) HWY_ATTR { alpha[j] = hn::Set(d, batch.constant[entries[j]]); });
  add(batch.x, place.x);
  add(batch.y, place.y);
  add(batch.xx, place.xx);
  add(batch.xy, place.xy);
  add(batch.yy, place.yy);
  each([&](std::uint32_t j) HWY_ATTR { counts[j] = hn::Ge(alpha[j], hn::Set(d, -kLog2Of255)); });
  if constexpr (kClamps) {
    each([&](std::uint32_t j)
             HWY_ATTR { alpha[j] = hn::Min(alpha[j], hn::Set(d, batch.limit[entries[j]])); });
  }
  exp2_polynomial(alpha);
}

/// Composites the batch's entries onto pixels [at, at + kLanes) of a cell. `before` is the number
/// of list entries in front of the batch. True if a pixel is still live.
template <bool kClamps>
HWY_INLINE bool blend_pixels(const Batch& batch, std::uint32_t before, int index, int at,
                             Cell& cell, std::uint32_t* evaluated) {
  const D d;
  const DU du;
  const Place place(index, at);
  const V least = hn::Set(d, kTransmittanceMin);
  Pixels pixels(cell, at);
  M live = pixels.live();
  const std::uint32_t count = batch.counts[index];
  for (std::uint32_t i = 0; i < count && !hn::AllFalse(d, live); i += kChains) {
    const std::uint32_t* entries = batch.reaching[index] + i;
    V alpha[kChains], weight[kChains];
    M counts[kChains];
    alphas_of<kClamps>(batch, entries, place, alpha, counts);
    V transmittance = pixels.transmittance;
    each([&](std::uint32_t j) HWY_ATTR {
      weight[j] = hn::IfThenElseZero(counts[j], hn::Mul(alpha[j], transmittance));
      transmittance = hn::Sub(transmittance, weight[j]);
    });
    // Usually no pixel stops, so the entries are blended together.
    const M stops = hn::And(live, hn::Lt(transmittance, least));
    if (HWY_LIKELY(hn::AllFalse(d, stops))) {
      pixels.transmittance = transmittance;
      each([&](std::uint32_t j) HWY_ATTR { pixels.add(batch, entries[j], weight[j]); });
      continue;
    }
    // Otherwise find the entry at which each pixel stops.
    each([&](std::uint32_t j) HWY_ATTR {
      const V all = hn::IfThenElseZero(counts[j], hn::Mul(alpha[j], pixels.transmittance));
      const V after = hn::Sub(pixels.transmittance, all);
      const M stop = hn::And(live, hn::Lt(after, least));
      hn::Store(hn::IfThenElse(hn::RebindMask(du, stop), hn::Set(du, before + entries[j] + 1),
                               hn::Load(du, evaluated + at)),
                du, evaluated + at);
      live = hn::AndNot(stop, live);
      pixels.transmittance = hn::IfThenElseZero(live, after);
      pixels.add(batch, entries[j], hn::IfThenElseZero(live, all));
    });
  }
  pixels.store(cell, at);
  return !hn::AllFalse(d, live);
}

template <bool kClamps>
HWY_INLINE void blend_batch(const Batch& batch, std::uint32_t before, Tile& tile) {
  for (int cell = 0; cell < kCells; ++cell) {
    if (!tile.open[cell]) continue;
    bool live = false;
    for (int at = 0; at < kCellPixels; at += kLanes)
      live |=
          blend_pixels<kClamps>(batch, before, cell, at, tile.cells[cell], tile.evaluated[cell]);
    tile.open[cell] = live;
  }
}

void blend_onto(const Batch& batch, std::uint32_t before, Tile& tile) {
  batch.limited ? blend_batch<true>(batch, before, tile) : blend_batch<false>(batch, before, tile);
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(blend_onto);

void blend_tile(const TileJob& job) {
  Tile tile(job);
  Batch batch;
  for (std::uint32_t first = 0; first < job.length && tile.live(); first += Batch::kEntries) {
    batch.load(job, first, std::min(Batch::kEntries, job.length - first), tile.open);
    HWY_DYNAMIC_DISPATCH(blend_onto)(batch, first, tile);
  }
  tile.write(job);
}

}  // namespace qs::cpu::fast
#endif
