// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/batch.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/batch.cpp"
#include "raster/cpu/fast/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, Batch::kVector>;
using DI = hn::RebindToSigned<D>;
using DU = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

constexpr std::uint32_t kLanes = static_cast<std::uint32_t>(hn::MaxLanes(D()));
constexpr int kFloats = sizeof(Record) / sizeof(float);

/// The same field of kLanes records, addressed in the first record.
struct Fields {
  const Record& first;

  HWY_INLINE V operator()(const float& field_of_first) const {
    const DI di;
    const auto steps = hn::Mul(hn::Iota(di, 0), hn::Set(di, kFloats));
    return hn::GatherIndex(D(), &field_of_first, steps);
  }
};

/// Records side by side, so that vectors of a field can be gathered with constant indices.
struct Records {
  Record records[Batch::kEntries];

  HWY_INLINE void load(const TileJob& job, std::uint32_t first, std::uint32_t size) {
    const std::uint32_t* list = job.list + first;
    const std::uint32_t next = std::min(Batch::kEntries, job.length - first - size);
    for (std::uint32_t k = 0; k < size; ++k) records[k] = job.records[list[k]];
    for (std::uint32_t k = 0; k < next; ++k) __builtin_prefetch(&job.records[list[size + k]]);
    Record none{};
    none.ellipse.y_max = -1;
    none.limit = kNoLimit;
    for (std::uint32_t k = size; k % kLanes != 0; ++k) records[k] = none;
  }
};

/// Writes the polynomials and colours of entries [k, k + kLanes).
HWY_INLINE void stage(const Fields& field, glm::vec3 background, V u, V v, std::uint32_t k,
                      Batch& batch) {
  const D d;
  const Record& first = field.first;
  const V xx = field(first.a), xy = field(first.b), yy = field(first.c);
  const V half = hn::Set(d, 0.5f), log2_opacity = field(first.log2_opacity);
  const V x = hn::MulAdd(hn::Add(xx, xx), u, hn::Mul(xy, v));
  const V y = hn::MulAdd(hn::Add(yy, yy), v, hn::Mul(xy, u));
  const V twice = hn::MulAdd(x, u, hn::Mul(y, v));
  hn::Store(hn::MulAdd(half, twice, log2_opacity), d, batch.constant + k);
  hn::Store(x, d, batch.x + k);
  hn::Store(y, d, batch.y + k);
  hn::Store(xx, d, batch.xx + k);
  hn::Store(xy, d, batch.xy + k);
  hn::Store(yy, d, batch.yy + k);
  const V limit = field(first.limit);
  hn::Store(limit, d, batch.limit + k);
  batch.limited |= !hn::AllTrue(d, hn::Eq(limit, hn::Set(d, kNoLimit)));
  hn::Store(hn::Sub(field(first.red), hn::Set(d, background.x)), d, batch.red + k);
  hn::Store(hn::Sub(field(first.green), hn::Set(d, background.y)), d, batch.green + k);
  hn::Store(hn::Sub(field(first.blue), hn::Set(d, background.z)), d, batch.blue + k);
}

/// Appends entries [k, k + kLanes) to the cells that they reach. Over a row of cells, the ellipse
/// is widest at its own extreme or at the end of the row nearest to it.
HWY_INLINE void find_cells(const Fields& field, V u, V v, const bool* open, std::uint32_t k,
                           Batch& batch) {
  const D d;
  const DU du;
  const AlphaEllipse& e = field.first.ellipse;
  const V y_max = field(e.y_max), slope = field(e.slope), v_extreme = field(e.v_extreme),
          half2 = field(e.half2), narrowing = field(e.narrowing), margin = field(e.margin);
  const V from_first = hn::Add(u, hn::Set(d, -0.5f * (kTileSize - 1)));
  const V top = hn::Add(v, hn::Set(d, -0.5f * (kTileSize - 1)));
  const auto numbers = hn::Iota(du, k);
  for (int row = 0; row < kCellsInRow; ++row) {
    const V low = hn::Add(top, hn::Set(d, float(row * kCellSide)));
    const V high = hn::Add(low, hn::Set(d, float(kCellSide - 1)));
    const V v0 = hn::Max(low, hn::Neg(y_max)), v1 = hn::Min(high, y_max);
    const auto half_at = [&](V at) HWY_ATTR {
      const V square = hn::NegMulAdd(hn::Mul(narrowing, at), at, half2);
      return hn::Add(hn::Sqrt(hn::Max(square, hn::Zero(d))), margin);
    };
    const V v_right = hn::Min(hn::Max(v_extreme, v0), v1);
    const V v_left = hn::Min(hn::Max(hn::Neg(v_extreme), v0), v1);
    // Relative to the tile's first pixel.
    const V right = hn::Sub(hn::MulAdd(slope, v_right, half_at(v_right)), from_first);
    const V left = hn::Sub(hn::MulSub(slope, v_left, half_at(v_left)), from_first);
    const M meets = hn::Le(v0, v1);
    for (int column = 0; column < kCellsInRow; ++column) {
      const int cell = row * kCellsInRow + column;
      if (!open[cell]) continue;
      const M reached = hn::And(
          meets, hn::And(hn::Ge(right, hn::Set(d, float(column * kCellSide))),
                         hn::Le(left, hn::Set(d, float(column * kCellSide + kCellSide - 1)))));
      // Compresses in a register, because compressing stores are slow on some CPUs.
      hn::StoreU(hn::Compress(numbers, hn::RebindMask(du, reached)), du,
                 batch.reaching[cell] + batch.counts[cell]);
      batch.counts[cell] += static_cast<std::uint32_t>(hn::CountTrue(d, reached));
    }
  }
}

void load_batch(const TileJob& job, std::uint32_t first, std::uint32_t size, const bool* open,
                Batch& batch) {
  const D d;
  Records loaded;
  loaded.load(job, first, size);
  std::fill_n(batch.counts, kCells, 0u);
  batch.limited = false;
  const V middle_x = hn::Set(d, static_cast<float>(job.x0) + 0.5f * (kTileSize - 1));
  const V middle_y = hn::Set(d, static_cast<float>(job.y0) + 0.5f * (kTileSize - 1));
  for (std::uint32_t k = 0; k < size; k += kLanes) {
    const Record& record = loaded.records[k];
    const Fields field{record};
    const V u = hn::Sub(middle_x, field(record.mean_x));
    const V v = hn::Sub(middle_y, field(record.mean_y));
    stage(field, job.background, u, v, k, batch);
    find_cells(field, u, v, open, k, batch);
  }
  for (int cell = 0; cell < kCells; ++cell) {
    for (std::uint32_t k = 0; k < Batch::kMultiple - 1; ++k)
      batch.reaching[cell][batch.counts[cell] + k] = Batch::kNone;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(load_batch);

Batch::Batch() {
  constant[kNone] = -1e6f;
  for (float* factors : {x, y, xx, xy, yy, limit, red, green, blue}) factors[kNone] = 0;
}

void Batch::load(const TileJob& job, std::uint32_t first, std::uint32_t size, const bool* open) {
  HWY_DYNAMIC_DISPATCH(load_batch)(job, first, size, open, *this);
}

}  // namespace qs::cpu::fast
#endif
