// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include "raster/cpu/fast/pipeline.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/sort.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DU = hn::CappedTag<std::uint32_t, 16>;
using U = hn::Vec<DU>;
using M = hn::Mask<DU>;

constexpr std::uint32_t kLanes = static_cast<std::uint32_t>(hn::MaxLanes(DU()));
static_assert(VisibleSlots::kChunk % kLanes == 0);

/// Calls visit(first slot, mask of the Gaussians that reach the band) for vectors of slots.
template <class Visit>
HWY_INLINE void for_each_in(const FastVisible& visible, const Band& band, Visit&& visit) {
  const DU du;
  const U top = hn::Set(du, static_cast<std::uint32_t>(band.top));
  const U bottom = hn::Set(du, static_cast<std::uint32_t>(band.bottom));
  const U lanes = hn::Iota(du, 0);
  for (std::size_t chunk = 0; chunk < visible.chunk_counts.size(); ++chunk) {
    const auto first = static_cast<std::uint32_t>(chunk * VisibleSlots::kChunk);
    const std::uint32_t count = visible.chunk_counts[chunk];
    for (std::uint32_t k = 0; k < count; k += kLanes) {
      const U rows = hn::LoadU(du, visible.rows.data() + first + k);
      const U begin = hn::And(rows, hn::Set(du, 0xffffu)), end = hn::ShiftRight<16>(rows);
      const M used = hn::Gt(hn::Set(du, count - k), lanes);
      visit(first + k, hn::And(used, hn::And(hn::Gt(bottom, begin), hn::Gt(end, top))));
    }
  }
}

/// Fills `items` of the band with the Gaussians that reach it, in order of slots. Returns the range
/// of the keys.
KeyRange gather_band(const FastVisible& visible, Band& band) {
  const DU du;
  std::size_t count = 0;
  for_each_in(visible, band,
              [&](std::uint32_t, M reached) HWY_ATTR { count += hn::CountTrue(du, reached); });
  band.items.resize(count + kLanes);  // whole vectors are stored
  U low = hn::Set(du, ~0u), high = hn::Zero(du);
  std::size_t to = 0;
  const U lanes = hn::Iota(du, 0);
  for_each_in(visible, band, [&](std::uint32_t slot, M reached) HWY_ATTR {
    const U keys =
        hn::BitCast(du, hn::LoadU(hn::RebindToFloat<DU>(), visible.depths.data() + slot));
    low = hn::Min(low, hn::IfThenElse(reached, keys, low));
    high = hn::Max(high, hn::IfThenElseZero(reached, keys));
    hn::StoreU(hn::Compress(keys, reached), du, band.items.keys.data() + to);
    hn::StoreU(hn::Compress(hn::Add(lanes, hn::Set(du, slot)), reached), du,
               band.items.values.data() + to);
    to += hn::CountTrue(du, reached);
  });
  band.items.resize(count);
  return {hn::GetLane(hn::MinOfLanes(du, low)), hn::GetLane(hn::MaxOfLanes(du, high))};
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(gather_band);
namespace {

/// Divides the tile rows into a band per thread, with about the same number of pairs.
void find_bands(const FrameContext& frame, const FastVisible& visible, Bands& bands) {
  const auto count = static_cast<std::size_t>(frame.pool.size());
  const auto rows = static_cast<std::size_t>(frame.grid.rows);
  while (bands.size() < count) bands.push_back(std::make_unique<Band>());
  bands.resize(count);

  // Pairs that begin in a row, from corner differences: a rectangle of c columns adds c to its
  // first row and takes it away below its last row.
  const std::size_t columns = static_cast<std::size_t>(frame.grid.columns);
  const auto begun = [&](std::size_t row) {
    std::int64_t sum = 0;
    for (const Array<std::int32_t>& corners : visible.corners)
      for (std::size_t column = 0; column < columns; ++column)
        sum += corners[row * (columns + 1) + column] * static_cast<std::int64_t>(columns - column);
    return sum;
  };
  std::int64_t all = 0, in_row = 0;
  for (std::size_t row = 0; row < rows; ++row) all += in_row += begun(row);
  std::int64_t above = 0;
  std::size_t row = 0;
  in_row = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t target =
        all * static_cast<std::int64_t>(i + 1) / static_cast<std::int64_t>(count);
    bands[i]->top = static_cast<int>(row);
    for (; row < rows && (above < target || i + 1 == count); ++row) above += in_row += begun(row);
    bands[i]->bottom = static_cast<int>(row);
  }
}

/// Sorts runs of equal depth by index in the cloud, because the radix sort left them in order of
/// slots, which is spatial. Ties are found without branches and their indices prefetched.
void order_ties(const VisibleSlots& visible, SortItems& items) {
  constexpr std::size_t kBatch = 512;
  const std::uint32_t* keys = items.keys.data();
  const std::uint32_t* gaussians = visible.gaussians.data();
  const std::size_t size = items.keys.size();
  const auto earlier = [&](std::uint32_t a, std::uint32_t b) {
    return gaussians[a] < gaussians[b];
  };
  for (std::size_t begin = 0; begin + 1 < size; begin += kBatch) {
    // Find the items that have the depth of the next item.
    std::size_t ties[kBatch], count = 0;
    const std::size_t end = std::min(begin + kBatch, size - 1);
    for (std::size_t i = begin; i < end; ++i) {
      ties[count] = i;
      count += static_cast<std::size_t>(keys[i] == keys[i + 1]);
    }
    // Keep the first item of each run.
    std::size_t runs = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = ties[k];
      if (i > 0 && keys[i - 1] == keys[i]) continue;
      __builtin_prefetch(gaussians + items.values[i]);
      __builtin_prefetch(gaussians + items.values[i + 1]);
      ties[runs++] = i;
    }
    // Sort the runs.
    for (std::size_t k = 0; k < runs; ++k) {
      const std::size_t i = ties[k];
      std::size_t length = 2;
      while (i + length < size && keys[i + length] == keys[i]) ++length;
      std::uint32_t* slots = &items.values[i];
      if (length > 2) {
        std::sort(slots, slots + length, earlier);
      } else if (earlier(slots[1], slots[0])) {
        std::swap(slots[0], slots[1]);
      }
    }
  }
}

}  // namespace

// Depths are positive floats; their bits order like unsigned integers.
void sort(const FrameContext& frame, const FastVisible& visible, Bands& bands) {
  find_bands(frame, visible, bands);
  frame.for_chunks(bands.size(), 1, [&](std::size_t i, std::size_t, int) {
    Band& band = *bands[i];
    const KeyRange range = HWY_DYNAMIC_DISPATCH(gather_band)(visible, band);
    radix_sort(band.items, range, band.alone, frame.stop);
    order_ties(visible, band.items);
  });
}

}  // namespace qs::cpu::fast
#endif
