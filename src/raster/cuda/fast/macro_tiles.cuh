// SPDX-License-Identifier: MIT
//
// A macro-tile is a block of 4x2 tiles. `project` appends every visible Gaussian to the macro-tiles
// in which its mode lists a tile, in any order; list.cu sorts them and writes the tiles' lists.
// If a macro-tile has too many Gaussians for a block to sort, all macro-tiles keep kUsual of them.
// The others are spilled into an array that all macro-tiles share, and the Gaussians of a full
// macro-tile are cut by depth into slices that blocks sort independently. Samples determine the
// cuts (Frazer and McKellar, Samplesort, 1970).
#pragma once

#include "raster/cuda/common/block_sort.cuh"
#include "raster/cuda/common/device_buffer.cuh"
#include "raster/kernel/hd.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cuda::fast {

/// A number of `bits` bits, 1 to 31, that varies strongly with the value (Knuth, multiplicative
/// hashing).
__device__ inline std::uint32_t hash_of(std::uint32_t value, std::uint32_t bits) {
  return value * 2654435761u >> (32 - bits);
}

/// The sizes of the memory for macro-tiles and slices, chosen from the needs of earlier frames.
struct MacroSize {
  static constexpr std::uint32_t kUsual = kUsualSort;
  /// The capacity of slices if usual ones need more samples than a block can sort in shared memory.
  /// Two blocks share a multiprocessor.
  static constexpr std::uint32_t kMedium = 10240;

  /// The largest capacity with which blocks sort macro-tiles whole. Larger ones take a block longer
  /// than their slices take many blocks, see docs/log/far.md.
  static constexpr std::uint32_t kMostWhole = 7 * kUsual;

  std::uint32_t capacity = kUsual;      ///< Gaussians that a macro-tile keeps, at least kUsual
  std::uint32_t slice_capacity = 0;     ///< Gaussians in a slice; 0: the frame has no slices
  std::uint32_t slice_target = 0;       ///< Gaussians in a slice on average, < slice_capacity
  std::uint32_t sample_capacity = 0;    ///< samples of a macro-tile
  bool sorts_in_global_memory = false;  ///< the samples, because shared memory is too small
  std::uint32_t log2_distance = 0;      ///< between the samples in a macro-tile, on average
  std::uint32_t slices = 0;             ///< slices of all macro-tiles
  std::uint32_t spilled = 0;            ///< spilled entries in each of Slicing::kParts parts

  QS_HD bool has_slices() const { return slice_capacity > 0; }
  /// True if blocks sort macro-tiles with more than the usual number of Gaussians whole.
  bool keeps_whole() const { return capacity > kUsual; }
};

/// The memory with which full macro-tiles are cut: spilled entries, samples and slices. A kernel
/// parameter.
struct Slicing {
  static constexpr std::uint32_t kLeastSamples = 16;  ///< per slice, on average
  static constexpr unsigned kGlobalSorts = 32;        ///< blocks that sort in global memory
  /// Spilled entries are counted in this number of parts, because additions to one counter are
  /// slow. The counters are in different cache lines.
  static constexpr std::uint32_t kParts = 64, kCounterStride = 32;

  struct Slices {
    std::uint32_t first, count;
  };

  MacroSize size;
  SortEntry* spilled;            ///< size.spilled for each part
  std::uint32_t* spilled_tiles;  ///< per spilled entry: macro-tile << 8 | mask of tiles
  std::uint32_t* part_counts;    ///< per part: entries, also those beyond the capacity
  SortEntry* samples;            ///< size.sample_capacity for each macro-tile
  std::byte* sort_memory;        ///< sort memory of kGlobalSorts blocks, see MacroSize
  Slices* slices;                ///< per full macro-tile
  std::uint32_t* macro_tile_of;  ///< per slice
  std::uint64_t* least_keys;     ///< per slice: the key of its first entry
  std::uint32_t* counts;         ///< per slice: entries, also those beyond the capacity
  std::uint64_t* list_begins;    ///< per slice and tile: where its part of the list begins
  std::uint32_t* sample_begins;  ///< the same for the samples of the list, see CutRule
  SortEntry* entries;            ///< size.slice_capacity for each slice
  std::uint16_t* masks;          ///< per entry: MarkedTiles

  /// Memory of a block that sorts `samples` samples.
  static constexpr std::size_t sort_bytes(std::uint32_t samples) {
    return samples * 3 * sizeof(std::uint32_t);
  }
  static constexpr std::size_t counters() { return kParts * kCounterStride; }
  static __device__ unsigned own_part() { return blockIdx.x % kParts; }
  __device__ std::uint32_t* part_count(unsigned part) const {
    return part_counts + part * kCounterStride;
  }

  /// Stores the entry at `slot` of a macro-tile if it is a sample: one in every 2^log2_distance
  /// slots, at a place that varies, so that the order of the scene hardly matters.
  __device__ void sample(unsigned macro_tile, std::uint32_t slot, SortEntry entry) const {
    const std::uint32_t number = slot >> size.log2_distance;
    const std::uint32_t place = hash_of(number, size.log2_distance);
    if (slot != (number << size.log2_distance | place) || number >= size.sample_capacity) return;
    samples[std::size_t{macro_tile} * size.sample_capacity + number] = entry;
  }
  __device__ std::uint32_t sample_count(std::uint32_t entries_of_macro_tile) const {
    return min(entries_of_macro_tile >> size.log2_distance, size.sample_capacity);
  }

  /// Stores an entry at place `slot` of the block's part.
  __device__ void spill(std::uint32_t slot, unsigned macro_tile, SortEntry entry,
                        unsigned mask) const {
    if (slot >= size.spilled) return;
    const std::size_t place = std::size_t{own_part()} * size.spilled + slot;
    spilled[place] = entry;
    spilled_tiles[place] = macro_tile << 8 | mask;
  }

  /// True if the slices fit into the memory.
  __device__ bool holds(Slices own) const { return own.first + own.count <= size.slices; }
};

/// The macro-tiles of a frame. A kernel parameter.
struct MacroTiles {
  static constexpr int kColumns = 4, kRows = 2;
  static constexpr int kTiles = kColumns * kRows;
  static constexpr std::uint32_t kUsual = MacroSize::kUsual;  ///< Gaussians
  /// Bytes of an entry and its mask.
  static constexpr std::uint64_t kBytesEach = sizeof(SortEntry) + 1;
  /// Of a picture of 16384 x 16384 pixels. Their entries take 3.6 GB.
  static constexpr std::size_t kMost = 256 * 512;

  std::uint32_t* counts;  ///< per macro-tile: its Gaussians, spilled Gaussians included
  SortEntry* entries;     ///< slicing.size.capacity for each
  std::uint8_t* masks;    ///< per entry: the tiles that it lists, see MacroMask
  std::uint32_t* order;   ///< all macro-tiles, the fullest first
  EntryOrder entry_order;
  int columns, rows;
  Slicing slicing;

  QS_HD int count() const { return columns * rows; }

  /// Adds a Gaussian that lists the tiles `mask` of a macro-tile.
  __device__ void append(unsigned macro_tile, SortEntry entry, unsigned mask) const {
    const std::uint32_t slot = atomicAdd(&counts[macro_tile], 1u);
    const unsigned part = Slicing::own_part();
    const std::uint32_t spilled =
        slot < slicing.size.capacity ? 0 : atomicAdd(slicing.part_count(part), 1u);
    store(macro_tile, slot, spilled, entry, mask);
  }

  /// Stores an entry at its slot, or at place `spilled` of the block's part if it is spilled.
  __device__ void store(unsigned macro_tile, std::uint32_t slot, std::uint32_t spilled,
                        SortEntry entry, unsigned mask) const {
    if (slot < slicing.size.capacity) {
      const std::size_t place = std::size_t{macro_tile} * slicing.size.capacity + slot;
      entries[place] = entry;
      masks[place] = static_cast<std::uint8_t>(mask);
    } else {
      slicing.spill(spilled, macro_tile, entry, mask);
    }
    if (slicing.size.has_slices()) slicing.sample(macro_tile, slot, entry);
  }

  static int columns_of(TileGrid grid) { return (grid.columns + kColumns - 1) / kColumns; }
  static int rows_of(TileGrid grid) { return (grid.rows + kRows - 1) / kRows; }
  static std::size_t count_of(TileGrid grid) {
    return static_cast<std::size_t>(columns_of(grid)) * static_cast<std::size_t>(rows_of(grid));
  }
};

}  // namespace qs::cuda::fast
