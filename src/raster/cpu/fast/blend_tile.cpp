// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cpu/fast/tile.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/blend_tile.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kCellPixels>;
using DU = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

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

/// The factor c 2^(n / 32 - 8) for every integer n, c = 0.241: from a table for n in [0, 32), in
/// bits less n << 18, and the rest of n is added to the exponent.
struct Exp2Table {
  hn::VFromD<DU> low, high;

  HWY_INLINE Exp2Table() {
    alignas(64) static constexpr float kPowers[] = {
        0.241099252f, 0.246378638f, 0.251773628f, 0.257286753f, 0.262920599f, 0.26867781f,
        0.274561088f, 0.280573193f, 0.286716946f, 0.29299523f,  0.29941099f,  0.305967237f,
        0.312667047f, 0.319513564f, 0.32651f,     0.333659638f, 0.340965832f, 0.348432012f,
        0.35606168f,  0.363858415f, 0.371825877f, 0.379967803f, 0.388288015f, 0.396790415f,
        0.405478994f, 0.414357828f, 0.423431083f, 0.432703016f, 0.442177978f, 0.451860415f,
        0.46175487f,  0.471865985f};
    low = half(kPowers, 0);
    high = half(kPowers, 16);
  }

  /// `shifted`: n / 32 + 1.5 2^18, so that its bits end with n.
  HWY_INLINE V operator()(V shifted) const {
    const DU du;
    const auto n = hn::BitCast(du, shifted);
    const hn::VFromD<DU> power{_mm512_permutex2var_epi32(low.raw, n.raw, high.raw)};
    return hn::BitCast(D(), hn::Add(power, hn::ShiftLeft<18>(n)));
  }

 private:
  static HWY_INLINE hn::VFromD<DU> half(const float* powers, std::uint32_t first) {
    const DU du;
    const auto bits =
        hn::Sub(hn::BitCast(du, hn::Load(D(), powers + first)), hn::Set(du, 8u << 23));
    return hn::Sub(bits, hn::ShiftLeft<18>(hn::Iota(du, first)));
  }
};

/// 2^(x - 8), relative error below 3e-7. AVX-512 looks up 32 floats with one instruction. The rest
/// of x is r in [-1/64, 1/64], and 2^r is 0.241 ((r + 46/32)^2 + 2.081).
HWY_INLINE void exp2_less_8(V (&x)[kChains]) {
  constexpr float kCenter = 46.0f / 32, kRest = 2.08126281f;
  const D d;
  const V round = hn::Set(d, kRoundToInteger / 32);
  const V round_and_center = hn::Set(d, kRoundToInteger / 32 + kCenter);
  const Exp2Table table;
  V shifted[kChains];
  each([&](std::uint32_t j) HWY_ATTR { shifted[j] = hn::Add(x[j], round); });
  each([&](std::uint32_t j)
           HWY_ATTR { x[j] = hn::Sub(x[j], hn::Sub(shifted[j], round_and_center)); });
  each([&](std::uint32_t j) HWY_ATTR { x[j] = hn::MulAdd(x[j], x[j], hn::Set(d, kRest)); });
  each([&](std::uint32_t j) HWY_ATTR { x[j] = hn::Mul(x[j], table(shifted[j])); });
}

#else

/// kernel/blend.h's exp2_polynomial() of x - 8, for x > -118; below, the result has no meaning.
HWY_INLINE void exp2_less_8(V (&x)[kChains]) {
  const D d;
  const DU du;
  const V round = hn::Set(d, kRoundToInteger - 8);
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

/// The rows of pixels [at, at + kLanes) of a cell, relative to the tile's middle.
HWY_INLINE V rows_of(int cell, int at) {
  const D d;
  const DU du;
  static_assert(kCellSide == 4);
  const auto pixel = hn::Iota(du, static_cast<std::uint32_t>(at));
  const auto row = hn::BitCast(hn::RebindToSigned<D>(), hn::ShiftRight<2>(pixel));
  return hn::Add(hn::ConvertTo(d, row),
                 hn::Set(d, float(cell / kCellsInRow * kCellSide) - 0.5f * (kTileSize - 1)));
}

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
    const Batch::Factors& factors = batch.factors[k];
    red = hn::MulAdd(hn::Set(d, factors.red), weight, red);
    green = hn::MulAdd(hn::Set(d, factors.green), weight, green);
    blue = hn::MulAdd(hn::Set(d, factors.blue), weight, blue);
  }
};

/// Computes the alphas of kChains entries at pixels in `rows` and in columns from `column` on; 0
/// below 1/255. kLimits: an alpha may exceed kAlphaMax.
template <bool kLimits>
HWY_INLINE void alphas_of(const Batch& batch, const std::uint32_t* entries, V rows, int column,
                          V (&alpha)[kChains]) {
  const D d;
  M counts[kChains];
  each([&](std::uint32_t j) HWY_ATTR {
    const V offset = hn::LoadDup128(d, batch.columns[entries[j]].offset + column);
    alpha[j] = hn::MulSub(hn::Set(d, batch.factors[entries[j]].scale), rows, offset);
  });
  each([&](std::uint32_t j) HWY_ATTR {
    const V level = hn::LoadDup128(d, batch.columns[entries[j]].level + column);
    alpha[j] = hn::NegMulAdd(alpha[j], alpha[j], level);
  });
  each([&](std::uint32_t j) HWY_ATTR { counts[j] = hn::Ge(alpha[j], hn::Set(d, 8 - kLog2Of255)); });
  if constexpr (kLimits)
    each([&](std::uint32_t j)
             HWY_ATTR { alpha[j] = hn::Min(alpha[j], hn::Set(d, kLog2Of256AlphaMax)); });
  exp2_less_8(alpha);
  each([&](std::uint32_t j) HWY_ATTR { alpha[j] = hn::IfThenElseZero(counts[j], alpha[j]); });
}

/// Notes for the pixels that stop at entry `number` of the list, counted from 1.
HWY_INLINE void note_stop(M stops, std::uint32_t number, std::uint32_t* evaluated) {
  const DU du;
  const auto old = hn::Load(du, evaluated);
  hn::Store(hn::IfThenElse(hn::RebindMask(du, stops), hn::Set(du, number), old), du, evaluated);
}

/// The work beside the colours, or in their place: `evaluated` notes where pixels stop, `seen` the
/// entries that they blend, `depths` the median depths.
enum class Notes { none, evaluated, seen, depths };

/// Composites the batch's entries onto pixels [at, at + kLanes) of a cell. `before` is the number
/// of list entries in front of the batch. True if a pixel is still live. Fills `evaluated` of the
/// cell, or `seen` of the list, if kNotes says so.
template <Notes kNotes, bool kLimits>
HWY_INLINE bool blend_pixels(const Batch& batch, std::uint32_t before, int index, int at,
                             Cell& cell, std::uint32_t* evaluated, std::uint8_t* seen) {
  const D d;
  const V rows = rows_of(index, at);
  const int column = index % kCellsInRow * kCellSide + at % kCellSide;
  const V least = hn::Set(d, batch.least_transmittance);
  Pixels pixels(cell, at);
  M live = pixels.live();
  const std::uint32_t count = batch.counts[index];
  const std::uint32_t* entries = batch.reaching[index];
  V next[kChains];
  if (count > 0) alphas_of<kLimits>(batch, entries, rows, column, next);
  for (std::uint32_t i = 0; i < count && !hn::AllFalse(d, live); i += kChains, entries += kChains) {
    V alpha[kChains];
    each([&](std::uint32_t j) HWY_ATTR { alpha[j] = next[j]; });
    // Ahead of the chain of transmittances, which would keep a CPU from starting on them.
    if (i + kChains < count) alphas_of<kLimits>(batch, entries + kChains, rows, column, next);
    each([&](std::uint32_t j) HWY_ATTR {
      const V weight = hn::Mul(alpha[j], pixels.transmittance);
      const M is_front = hn::Gt(pixels.transmittance, hn::Set(d, 0.5f));
      pixels.transmittance = hn::Sub(pixels.transmittance, weight);
      // A transmittance never grows, so pixels that have stopped stay below the least.
      const M still = hn::Ge(pixels.transmittance, least);
      if constexpr (kNotes == Notes::evaluated)
        note_stop(hn::AndNot(still, live), before + entries[j] + 1, evaluated + at);
      live = still;
      if constexpr (kNotes == Notes::seen) {
        if (!hn::AllFalse(d, hn::And(live, hn::Ge(weight, hn::Set(d, batch.weight)))))
          seen[before + entries[j]] = 1;
        // Behind less light than the weight nothing more is seen.
        live = hn::And(live, hn::Ge(pixels.transmittance, hn::Set(d, batch.weight)));
      } else {
        pixels.add(batch, entries[j], hn::IfThenElseZero(live, weight));
        if constexpr (kNotes == Notes::depths)
          pixels.blue =
              hn::IfThenElse(hn::And(is_front, hn::Le(pixels.transmittance, hn::Set(d, 0.5f))),
                             hn::Set(d, batch.factors[entries[j]].red), pixels.blue);
      }
    });
    pixels.transmittance = hn::IfThenElseZero(live, pixels.transmittance);  // avoids tiny numbers
  }
  pixels.store(cell, at);
  return !hn::AllFalse(d, live);
}

template <Notes kNotes, bool kLimits>
HWY_INLINE void blend_batch(const Batch& batch, std::uint32_t before, Tile& tile,
                            std::uint8_t* seen = nullptr) {
  for (int cell = 0; cell < kCells; ++cell) {
    if (!tile.open[cell]) continue;
    bool live = false;
    for (int at = 0; at < kCellPixels; at += kLanes)
      live |= blend_pixels<kNotes, kLimits>(batch, before, cell, at, tile.cells[cell],
                                            tile.evaluated[cell], seen);
    tile.open[cell] = live;
  }
}

void blend_onto(const Batch& batch, std::uint32_t before, const TileJob& job, Tile& tile) {
  if (job.seen != nullptr) {
    blend_batch<Notes::seen, true>(batch, before, tile, job.seen);
  } else if (job.depths) {
    blend_batch<Notes::depths, true>(batch, before, tile);
  } else if (job.evaluated != nullptr) {
    blend_batch<Notes::evaluated, true>(batch, before, tile);
  } else if (batch.limited) {
    blend_batch<Notes::none, true>(batch, before, tile);
  } else {
    blend_batch<Notes::none, false>(batch, before, tile);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(blend_onto);

namespace {

/// Requests the cache lines of the tile's pixels, which are written when the tile is done.
void prefetch_pixels(const TileJob& job) {
  constexpr int kFloats = 64 / sizeof(float);  // of a cache line
  if (job.color == nullptr) return;
  for (int row = 0; row < job.height; ++row) {
    const float* pixels = job.color + 3 * job.stride * static_cast<std::size_t>(row);
    for (int i = 0; i < 3 * job.width; i += kFloats) __builtin_prefetch(pixels + i, 1);
  }
}

}  // namespace

void blend_tile(const TileJob& job) {
  Tile tile(job);
  Batch batch(job);
  prefetch_pixels(job);
  for (std::uint32_t first = 0; first < job.length && tile.live(); first += Batch::kEntries) {
    batch.load(job, first, std::min(Batch::kEntries, job.length - first), tile.open);
    HWY_DYNAMIC_DISPATCH(blend_onto)(batch, first, job, tile);
  }
  tile.write(job);
}

}  // namespace qs::cpu::fast
#endif
