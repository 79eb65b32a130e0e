// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/tile.h"

#include <algorithm>
#include <cstring>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/tile.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, Batch::kVector>;
using DU = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));  // the same for unsigned

/// Prefetch distance in list entries.
constexpr std::uint32_t kPrefetch = 24;

/// The square root with a relative error below 2^-13. NaN for negative numbers.
HWY_INLINE V rough_root(V x) {
#if HWY_TARGET == HWY_AVX3
  return hn::Mul(x, hn::ApproximateReciprocalSqrt(x));
#else
  return hn::Sqrt(x);
#endif
}

HWY_INLINE std::uint64_t bits_of(M mask) {
  std::uint8_t bytes[8] = {};
  std::uint16_t bits;
  hn::StoreMaskBits(D(), mask, bytes);
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}

/// The bit of a cell among the cells that an entry reaches.
HWY_INLINE int bit_of(int cell) { return cell % kCellsInRow * kCellsInRow + cell / kCellsInRow; }

/// The place of a tile: its columns of pixels, and its middle.
struct Place {
  V x[kTileSize / kLanes];
  float middle_y;

  HWY_INLINE explicit Place(const TileJob& job)
      : middle_y(static_cast<float>(job.y0) + 0.5f * (kTileSize - 1)) {
    for (int at = 0; at < kTileSize; at += kLanes) {
      const V column = hn::Iota(D(), static_cast<float>(at));
      x[at / kLanes] = hn::Add(column, hn::Set(D(), static_cast<float>(job.x0)));
    }
  }
};

/// Computes the columns of an entry. Returns bits of the cells that it reaches: cells with a pixel
/// of alpha >= 1/256, or a little less.
HWY_INLINE std::uint32_t stage(const Record& record, const Place& place, Batch::Columns& columns) {
  constexpr float kMarginPx = 0.02f;
  constexpr float kHalf = 0.5f * (kCellSide - 1);
  const D d;
  std::uint64_t reached = 0;  // bit 16 row of cells + column of pixels
  for (int at = 0; at < kTileSize; at += kLanes) {
    const V dx = hn::Sub(place.x[at / kLanes], hn::Set(d, record.mean_x));
    const V level = hn::NegMulAdd(hn::Mul(dx, hn::Set(d, record.along)), dx,
                                  hn::Set(d, record.log2_256_opacity));
    // The row in which the column's alpha is largest.
    const V row =
        hn::MulAdd(dx, hn::Set(d, record.slope), hn::Set(d, record.mean_y - place.middle_y));
    hn::Store(level, d, columns.level + at);
    hn::Store(hn::Mul(row, hn::Set(d, record.scale)), d, columns.offset + at);
    // Rows from a cell's middle to the farthest center; NaN if the column is too faint.
    const V reach =
        hn::MulAdd(rough_root(level), hn::Set(d, record.height), hn::Set(d, kMarginPx + kHalf));
    for (int cells = 0; cells < kCellsInRow; ++cells) {
      const float center = float(cells * kCellSide) + kHalf - 0.5f * (kTileSize - 1);
      const M meets = hn::Le(hn::Abs(hn::Sub(row, hn::Set(d, center))), reach);
      reached |= bits_of(meets) << (cells * kTileSize + at);
    }
  }
  static_assert(kCellSide == 4 && kTileSize == 16);
  reached |= reached >> 1;  // of the columns of a cell
  reached = (reached | reached >> 2) & 0x1111111111111111;
  reached = (reached | reached >> 15) & 0x0000333300003333;
  return static_cast<std::uint32_t>((reached | reached >> 30) & 0xffff);
}

/// Copies the factors of an entry. `background`: 0 and the background's colour.
HWY_INLINE void stage(const Record& record, const float* background, Batch::Factors& factors) {
  const hn::CappedTag<float, 4> d;
  for (std::size_t i = 0; i < 4; i += hn::Lanes(d)) {
    const auto values = hn::LoadU(d, &record.scale + i);
    hn::Store(hn::Sub(values, hn::Load(d, background + i)), d, &factors.scale + i);
  }
}

/// Lists the entries that reach a cell; `bit`: the cell's.
HWY_INLINE std::uint32_t list_cell(const std::uint32_t* reached, std::uint32_t size, int bit,
                                   std::uint32_t* list) {
  const DU du;
  const auto flag = hn::Set(du, 1u << bit);
  std::uint32_t count = 0;
  auto numbers = hn::Iota(du, 0);
  for (std::uint32_t k = 0; k < size; k += kLanes) {
    const auto reaches = hn::TestBit(hn::Load(du, reached + k), flag);
    // Compresses in a register, because compressing stores are slow on some CPUs.
    hn::StoreU(hn::Compress(numbers, reaches), du, list + count);
    count += static_cast<std::uint32_t>(hn::CountTrue(du, reaches));
    numbers = hn::Add(numbers, hn::Set(du, std::uint32_t{kLanes}));
  }
  for (std::uint32_t k = 0; k < Batch::kMultiple - 1; ++k) list[count + k] = Batch::kNone;
  return count;
}

void load_batch(const TileJob& job, std::uint32_t first, std::uint32_t size, const bool* open,
                Batch& batch) {
  const std::uint32_t* list = job.list + first;
  const std::uint32_t last = job.length - first - 1;
  const Place place(job);
  alignas(16) const float background[4] = {0, job.background.x, job.background.y, job.background.z};
  float brightest = 0;
  alignas(64) std::uint32_t reached[Batch::kEntries + Batch::kVector];
  for (std::uint32_t k = 0; k < size; ++k) {
    __builtin_prefetch(&job.records[list[std::min(k + kPrefetch, last)]]);
    const Record& record = job.records[list[k]];
    reached[k] = stage(record, place, batch.columns[k]);
    stage(record, background, batch.factors[k]);
    brightest = std::max(brightest, record.log2_256_opacity);
  }
  batch.limited = brightest > kLog2Of256AlphaMax;
  std::fill_n(reached + size, Batch::kVector, 0u);
  for (int cell = 0; cell < kCells; ++cell)
    batch.counts[cell] =
        open[cell] ? list_cell(reached, size, bit_of(cell), batch.reaching[cell]) : 0;
}

/// Writes the colours of `count` pixels of one row of a cell, from pixel `from`.
HWY_INLINE void write_pixels(const Cell& cell, int from, int count, float* color) {
  const hn::CappedTag<float, kCellSide> d;
  if (count == kCellSide) {
    for (int i = from; i < from + count; i += static_cast<int>(hn::Lanes(d)))
      hn::StoreInterleaved3(hn::LoadU(d, cell.red + i), hn::LoadU(d, cell.green + i),
                            hn::LoadU(d, cell.blue + i), d, color + 3 * (i - from));
    return;
  }
  for (int i = from; i < from + count; ++i, color += 3) {
    color[0] = cell.red[i];
    color[1] = cell.green[i];
    color[2] = cell.blue[i];
  }
}

void write_tile(const Tile& tile, const TileJob& job) {
  for (int row = 0; row < job.height; ++row) {
    const std::size_t begin = static_cast<std::size_t>(row) * job.stride;
    for (int column = 0; column < job.width; column += kCellSide) {
      const int count = std::min(kCellSide, job.width - column);
      const int cell = Tile::cell_of(column, row), from = Tile::pixel_of(column, row);
      const std::size_t to = begin + static_cast<std::size_t>(column);
      if (job.color != nullptr) write_pixels(tile.cells[cell], from, count, job.color + 3 * to);
      if (job.evaluated != nullptr)
        std::copy_n(tile.evaluated[cell] + from, count, job.evaluated + to);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(load_batch);
HWY_EXPORT(write_tile);

Batch::Batch(const TileJob& job)
    : least_transmittance(job.least_transmittance),
      weight(std::max(job.weight, std::numeric_limits<float>::min())) {
  std::fill_n(columns[kNone].level, kTileSize, -1e6f);
  std::fill_n(columns[kNone].offset, kTileSize, 0.0f);
  factors[kNone] = {0, 0, 0, 0};
}

void Batch::load(const TileJob& job, std::uint32_t first, std::uint32_t size, const bool* open) {
  HWY_DYNAMIC_DISPATCH(load_batch)(job, first, size, open, *this);
}

Tile::Tile(const TileJob& job) {
  for (Cell& cell : cells) {
    std::fill_n(cell.transmittance, kCellPixels, 1.0f);
    std::fill_n(cell.red, kCellPixels, job.background.x);
    std::fill_n(cell.green, kCellPixels, job.background.y);
    std::fill_n(cell.blue, kCellPixels, job.background.z);
  }
  std::fill_n(open, kCells, true);
  std::fill_n(evaluated[0], kCells * kCellPixels, job.length);
  if (job.width == kTileSize && job.height == kTileSize && job.chosen == nullptr) return;
  std::fill_n(open, kCells, false);
  for (int row = 0; row < kTileSize; ++row) {
    for (int column = 0; column < kTileSize; ++column) {
      const int cell = cell_of(column, row);
      const bool inside = column < job.width && row < job.height;
      if (inside && (job.chosen == nullptr || job.chosen[row * kTileSize + column] != 0)) {
        open[cell] = true;
      } else {
        cells[cell].transmittance[pixel_of(column, row)] = 0;
      }
    }
  }
}

bool Tile::live() const {
  return std::any_of(open, open + kCells, [](bool cell) { return cell; });
}

void Tile::write(const TileJob& job) const { HWY_DYNAMIC_DISPATCH(write_tile)(*this, job); }

}  // namespace qs::cpu::fast
#endif
