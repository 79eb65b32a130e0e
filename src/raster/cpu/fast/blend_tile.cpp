// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/blend_tile.h"

#include <algorithm>

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

/// kernel/blend.h's exp2_polynomial().
HWY_INLINE V exp2_polynomial(D d, V x) {
  const DU du;
  x = hn::Max(x, hn::Set(d, -126.0f));
  const V round = hn::Set(d, kRoundToInteger);
  const V shifted = hn::Add(x, round);
  const V fraction = hn::Sub(x, hn::Sub(shifted, round));
  V p = hn::Set(d, kExp2C5);
  p = hn::MulAdd(p, fraction, hn::Set(d, kExp2C4));
  p = hn::MulAdd(p, fraction, hn::Set(d, kExp2C3));
  p = hn::MulAdd(p, fraction, hn::Set(d, kExp2C2));
  p = hn::MulAdd(p, fraction, hn::Set(d, kExp2C1));
  p = hn::MulAdd(p, fraction, hn::Set(d, 1.0f));
  const auto exponent = hn::ShiftLeft<23>(hn::BitCast(du, shifted));
  return hn::BitCast(d, hn::Add(hn::BitCast(du, p), exponent));
}

/// A batch of list entries and the cells in which each of them can count.
struct Queue {
  static constexpr std::uint32_t kBatch = 32;  ///< list entries at a time

  const Record* records[kBatch];
  std::uint32_t items[kBatch * kCells + kCells];  ///< entry in the batch * kCells + cell
};

/// Writes the items of the batch's entry `k` and returns their number. Conservative: it may include
/// cells in which no pixel counts.
HWY_INLINE std::size_t queue_cells(const Record& record, std::uint32_t k, const Tile& tile,
                                   std::uint32_t* items) {
  const D d;
  const DU du;
  const V zero = hn::Zero(d), side = hn::Set(d, float(kCellSide - 1));
  const V a = hn::Set(d, record.wide_a), b = hn::Set(d, record.b), c = hn::Set(d, record.wide_c);
  const auto falloff = [&](V x, V y) HWY_ATTR {
    return hn::MulAdd(hn::MulAdd(b, y, hn::Mul(a, x)), x, hn::Mul(hn::Mul(c, y), y));
  };
  std::size_t count = 0;
  for (int cell = 0; cell < kCells; cell += kLanes) {
    const V left = hn::Sub(hn::Load(d, tile.cell_x + cell), hn::Set(d, record.mean_x));
    const V top = hn::Sub(hn::Load(d, tile.cell_y + cell), hn::Set(d, record.mean_y));
    const V right = hn::Add(left, side), bottom = hn::Add(top, side);
    // The exponent is concave, so over a rectangle it is largest at the mean or on a side facing
    // it.
    const V x = hn::Min(hn::Max(zero, left), right), y = hn::Min(hn::Max(zero, top), bottom);
    const V y_at_x = hn::Min(hn::Max(hn::Mul(hn::Set(d, record.y_over_x), x), top), bottom);
    const V x_at_y = hn::Min(hn::Max(hn::Mul(hn::Set(d, record.x_over_y), y), left), right);
    const V largest = hn::Max(falloff(x, y_at_x), falloff(x_at_y, y));
    const M reached =
        hn::Ge(largest, hn::Add(hn::Set(d, record.threshold), hn::Load(d, tile.closed + cell)));
    // Compresses in a register, because compressing stores are slow on some CPUs.
    const auto numbers = hn::Add(hn::Load(du, tile.numbers + cell), hn::Set(du, k * kCells));
    hn::StoreU(hn::Compress(numbers, hn::RebindMask(du, reached)), du, items + count);
    count += hn::CountTrue(d, reached);
  }
  return count;
}

/// Composites one Gaussian onto one cell. `entry` is its 1-based position in the list. True if a
/// pixel stopped.
HWY_INLINE bool blend_cell(const Record& record, std::uint32_t entry, Cell& cell,
                           std::uint32_t* evaluated) {
  const D d;
  const DU du;
  bool any_stopped = false;
  for (int at = 0; at < kCellPixels; at += kLanes) {
    const V dx = hn::Sub(hn::Load(d, cell.x + at), hn::Set(d, record.mean_x));
    const V dy = hn::Sub(hn::Load(d, cell.y + at), hn::Set(d, record.mean_y));
    const V across = hn::MulAdd(hn::Set(d, record.b), dy, hn::Mul(hn::Set(d, record.a), dx));
    const V log2_opacity = hn::Set(d, record.log2_opacity);
    const V log2_alpha =
        hn::MulAdd(dx, across, hn::MulAdd(hn::Mul(hn::Set(d, record.c), dy), dy, log2_opacity));
    const V least = hn::Load(d, cell.log2_alpha_min + at);
    // It exceeds the opacity only if rounding broke the conic.
    const M counts = hn::And(hn::Ge(log2_alpha, least), hn::Le(log2_alpha, log2_opacity));
    V alpha =
        hn::IfThenElseZero(counts, hn::Min(exp2_polynomial(d, log2_alpha), hn::Set(d, kAlphaMax)));
    const V before = hn::Load(d, cell.transmittance + at);
    V after = hn::NegMulAdd(alpha, before, before);
    const M stop = hn::Lt(after, hn::Set(d, kTransmittanceMin));
    if (HWY_UNLIKELY(!hn::AllFalse(d, stop))) {
      any_stopped = true;
      alpha = hn::IfThenZeroElse(stop, alpha);
      after = hn::IfThenElse(stop, before, after);
      hn::Store(hn::IfThenElse(stop, hn::Set(d, INFINITY), least), d, cell.log2_alpha_min + at);
      hn::Store(hn::IfThenElse(hn::RebindMask(du, stop), hn::Set(du, entry),
                               hn::Load(du, evaluated + at)),
                du, evaluated + at);
    }
    const V weight = hn::Mul(alpha, before);
    hn::Store(after, d, cell.transmittance + at);
    const auto add = [&](float color, float* plane) HWY_ATTR {
      hn::Store(hn::MulAdd(weight, hn::Set(d, color), hn::Load(d, plane + at)), d, plane + at);
    };
    add(record.red, cell.red);
    add(record.green, cell.green);
    add(record.blue, cell.blue);
  }
  return any_stopped;
}

// Two loops instead of one: the number of cells per Gaussian is unpredictable, so the first loop
// queues cells without branches, and the second one composites the queue.
void blend_one_tile(const TileJob& job, Tile& tile) {
  Queue queue;
  for (std::uint32_t first = 0; first < job.length && tile.live; first += Queue::kBatch) {
    const std::uint32_t entries = std::min(Queue::kBatch, job.length - first);
    const std::uint32_t next = std::min(Queue::kBatch, job.length - first - entries);
    const std::uint32_t* list = job.list + first;
    for (std::uint32_t k = 0; k < next; ++k)
      __builtin_prefetch(&job.records[list[Queue::kBatch + k]]);
    std::size_t count = 0;
    for (std::uint32_t k = 0; k < entries; ++k) {
      queue.records[k] = &job.records[list[k]];
      count += queue_cells(*queue.records[k], k, tile, queue.items + count);
    }
    bool any_stopped = false;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t k = queue.items[i] / kCells, cell = queue.items[i] % kCells;
      any_stopped |=
          blend_cell(*queue.records[k], first + k + 1, tile.cells[cell], tile.evaluated[cell]);
    }
    if (any_stopped) tile.close_finished_cells();
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(blend_one_tile);

void blend_tile(const TileJob& job) {
  Tile tile(job);
  HWY_DYNAMIC_DISPATCH(blend_one_tile)(job, tile);
  tile.write(job);
}

}  // namespace qs::cpu::fast
#endif
