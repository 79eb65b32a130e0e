// SPDX-License-Identifier: MIT
//
// The counters, look-back words and macro-tiles of a frame on the device. Those that must be zero
// when the frame begins are contiguous.
#pragma once

#include "raster/cuda/device_buffer.cuh"
#include "raster/cuda/fast/radix_sort.cuh"
#include "raster/kernel/tile_grid.h"

namespace qs::cuda::fast {

struct Counters {
  std::uint64_t tile_pairs;  ///< all pairs of the frame
  std::uint32_t listed;      ///< pairs that fit into the buffers
  std::uint32_t visible;
  std::uint32_t max_pairs_in_a_tile;
  std::uint32_t long_lists;
  std::uint32_t segments;            ///< of all long lists
  std::uint32_t turns[2];            ///< half segments that warps have taken: first, and again
  std::uint32_t fullest_macro_tile;  ///< Gaussians in it
  std::uint32_t large;               ///< visible Gaussians that list too many lines of tiles
  std::uint32_t blocks_done;         ///< that have appended such Gaussians
};

/// A Gaussian in a macro-tile.
struct MacroEntry {
  std::uint32_t depth_key, gaussian;
};

/// Macro-tiles: blocks of kColumns x kRows tiles, see macro_tiles.cuh.
struct MacroTiles {
  static constexpr int kColumns = 4, kRows = 2;
  static constexpr int kTiles = kColumns * kRows;
  static constexpr std::uint32_t kUsual = 3072;  ///< Gaussians; fuller ones are listed apart
  static constexpr std::uint64_t kBytesEach = sizeof(MacroEntry) + 1;  ///< of an entry, its mask

  std::uint32_t* counts;   ///< Gaussians appended to each, also those beyond the capacity
  MacroEntry* entries;     ///< `capacity` for each
  std::uint8_t* masks;     ///< per entry: the tiles that it lists, see MacroMask
  std::uint32_t* order;    ///< all macro-tiles, the fullest first
  std::uint32_t capacity;  ///< 0: the frame is sorted globally
  int columns, rows;

  QS_HD int count() const { return columns * rows; }

  /// Adds a Gaussian that lists the tiles `mask` of a macro-tile.
  __device__ void append(unsigned macro_tile, MacroEntry entry, unsigned mask) const {
    store(macro_tile, atomicAdd(&counts[macro_tile], 1u), entry, mask);
  }

  /// Ignores entries beyond the capacity.
  __device__ void store(unsigned macro_tile, std::uint32_t slot, MacroEntry entry,
                        unsigned mask) const {
    if (slot >= capacity) return;
    const std::size_t place = std::size_t{macro_tile} * capacity + slot;
    entries[place] = entry;
    masks[place] = static_cast<std::uint8_t>(mask);
  }

  static int columns_of(TileGrid grid) { return (grid.columns + kColumns - 1) / kColumns; }
  static int rows_of(TileGrid grid) { return (grid.rows + kRows - 1) / kRows; }
};

/// A part of a long list. The segments of a list are adjacent.
struct Segment {
  static constexpr std::uint32_t kNoTile = 0xffffffffu;  ///< its list exceeds the buffers
  std::uint32_t tile, number;
  std::uint32_t counted;  ///< Gaussians in this part of the list, see LongList
};

/// The result of compositing a segment, per pixel of the tile. A pixel that stops in the segment
/// has transmittance 0, and its colour allows for the segments in front; other colours do not.
struct SegmentResult {
  float red[kTileSize * kTileSize], green[kTileSize * kTileSize], blue[kTileSize * kTileSize];
  float transmittance[kTileSize * kTileSize];
};

struct SegmentsView {
  Segment* segments;
  std::uint32_t* first_segments;  ///< per long list
  std::uint32_t* marks;           ///< a bit per pair of the long lists: counted, see LongList
  SegmentResult* results;
  std::uint32_t capacity;
  Counters* counters;

  /// The bits of a list that begins at pair p begin in word p / kPairsPerMark. A word has twice as
  /// many bits, so long lists leave room behind their last word and share none.
  static constexpr std::uint32_t kPairsPerMark = 16;

  /// Reserves `count` adjacent segments for the long list of a tile.
  __device__ void reserve(std::uint32_t tile, std::uint32_t count) const {
    const std::uint32_t first = atomicAdd(&counters->segments, count);
    const bool fits = first + count <= capacity;
    for (std::uint32_t i = 0; i < count && first + i < capacity; ++i) {
      segments[first + i] = {fits ? tile : Segment::kNoTile, i, 0};
    }
    const std::uint32_t list = atomicAdd(&counters->long_lists, 1u);
    if (list < capacity) first_segments[list] = first;
  }
};

struct FrameSize {
  std::uint32_t gaussians = 0;
  std::uint32_t pair_capacity = 0;     ///< tile pairs that the buffers can hold
  std::uint32_t segment_capacity = 0;  ///< segments of long lists that they can hold
  std::uint32_t macro_capacity = 0;    ///< see MacroTiles::capacity
  TileGrid grid;

  bool uses_macro_tiles() const { return macro_capacity > 0; }
  bool has_full_macro_tiles() const { return macro_capacity > MacroTiles::kUsual; }

  std::size_t macro_tiles() const {
    return static_cast<std::size_t>(MacroTiles::columns_of(grid)) *
           static_cast<std::size_t>(MacroTiles::rows_of(grid));
  }
  std::size_t macro_entries() const { return macro_capacity * macro_tiles(); }

  /// True if tile indices fit into 16 bits.
  bool uses_16_bit_keys() const { return grid.count() <= 1 << 16; }
};

/// Memory that must be set to zero.
struct ToClear {
  uint4* words;
  std::size_t count;
};

struct Scratch {
  Counters* counters = nullptr;
  MacroTiles macro_tiles{};
  std::uint32_t* depth_digits = nullptr;  ///< number of keys per digit, pass by pass
  std::uint32_t* depth_words = nullptr;   ///< look-back, pass by pass
  std::uint64_t* bin_words = nullptr;     ///< look-back
  std::uint32_t* tile_digits = nullptr;
  std::uint32_t* tile_words = nullptr;
  std::uint32_t* class_sizes = nullptr;  ///< see ScheduleView; null if there are too many tiles
  KeyRange* ranges = nullptr;            ///< per tile: its list in the sorted pairs
  std::uint32_t* schedule = nullptr;     ///< not set to zero
  SegmentsView segments{};               ///< not set to zero
  std::uint32_t* large = nullptr;        ///< Counters::large Gaussians; not set to zero

  /// Number of look-back words per pass.
  template <class Key>
  static std::size_t look_back_words(std::uint32_t items) {
    return std::size_t{DeviceCount{nullptr, items}.parts()} * kBins<Key>;
  }

  /// Points the members into the reserved memory. Returns the memory that must be cleared first.
  ToClear begin_frame(const FrameSize& size) {
    std::uint64_t* const base = memory_.data();
    const std::size_t words = lay_out(size, base).cleared;
    if (!size.uses_16_bit_keys()) class_sizes = nullptr;
    schedule = schedule_.data();
    segments = {segments_.data(), first_segments_.data(), marks_.data(),
                results_.data(),  size.segment_capacity,  counters};
    macro_tiles.entries = macro_entries_.data();
    macro_tiles.masks = macro_masks_.data();
    macro_tiles.order = macro_order_.data();
    macro_tiles.capacity = size.macro_capacity;
    macro_tiles.columns = MacroTiles::columns_of(size.grid);
    macro_tiles.rows = MacroTiles::rows_of(size.grid);
    large = large_.data();
    return {reinterpret_cast<uint4*>(base), words * sizeof *base / sizeof(uint4)};
  }

  /// True if the macro-tiles of a frame of this size leave half of the free memory to the rest.
  bool can_hold_macro_tiles(const FrameSize& size) const {
    const std::uint64_t held = macro_entries_.bytes() + macro_masks_.bytes();
    const std::uint64_t needed = MacroTiles::kBytesEach * size.macro_entries();
    return needed <= held || needed <= (DeviceMemory::now().free + held) / 2;
  }

  /// Throws Error(device) if memory is short.
  void reserve(const FrameSize& size) {
    memory_.reserve("the frame's counters", lay_out(size, nullptr).used);
    segments_.reserve("the frame's segments", size.segment_capacity);
    first_segments_.reserve("the frame's segments", size.segment_capacity);
    marks_.reserve("the frame's segments", size.pair_capacity / SegmentsView::kPairsPerMark + 1);
    results_.reserve("the frame's segments", size.segment_capacity);
    if (size.uses_macro_tiles()) {
      macro_entries_.reserve("the frame's macro-tiles", size.macro_entries());
      macro_masks_.reserve("the frame's macro-tiles", size.macro_entries());
      large_.reserve("the frame's Gaussians", size.gaussians);
      macro_order_.reserve("the frame's macro-tiles", size.macro_tiles());
    }
    if (!size.uses_16_bit_keys()) return;
    schedule_.reserve("the frame's tiles", kWarp * static_cast<std::size_t>(size.grid.count()));
  }

 private:
  struct Layout {
    std::size_t cleared, used;  // 64-bit words
  };

  /// Points the members into memory from `base` on, unless it is null.
  Layout lay_out(const FrameSize& size, std::uint64_t* base) {
    std::size_t used = 0;
    const auto place = [&]<class T>(T*& what, std::size_t count) {
      constexpr std::size_t kAlign = 16;  // words
      if (base != nullptr) what = reinterpret_cast<T*>(base + used);
      used += (count * sizeof(T) / sizeof *base + kAlign) / kAlign * kAlign;
    };
    using Narrow = std::uint16_t;
    using Wide = std::uint32_t;
    const auto tiles = static_cast<std::size_t>(size.grid.count());
    place(counters, 1);
    place(class_sizes, kWarp);
    if (size.uses_macro_tiles()) {
      place(macro_tiles.counts, size.macro_tiles());
      const std::size_t cleared = used;
      place(ranges, tiles);
      return {cleared, used};
    }
    place(depth_digits, Radix<Wide>::kPasses * kBins<Wide>);
    place(depth_words, Radix<Wide>::kPasses * look_back_words<Wide>(size.gaussians));
    place(bin_words, std::max(1u, blocks_for(size.gaussians)));
    place(tile_digits, Radix<Wide>::kPasses * kBins<Wide>);
    place(tile_words, size.uses_16_bit_keys()
                          ? Radix<Narrow>::kPasses * look_back_words<Narrow>(size.pair_capacity)
                          : Radix<Wide>::kPasses * look_back_words<Wide>(size.pair_capacity));
    place(ranges, tiles);
    return {used, used};
  }

  DeviceBuffer<std::uint64_t> memory_;
  DeviceBuffer<std::uint32_t> schedule_;
  DeviceBuffer<MacroEntry> macro_entries_;
  DeviceBuffer<std::uint8_t> macro_masks_;
  DeviceBuffer<std::uint32_t> large_;
  DeviceBuffer<std::uint32_t> macro_order_;
  DeviceBuffer<Segment> segments_;
  DeviceBuffer<std::uint32_t> first_segments_, marks_;
  DeviceBuffer<SegmentResult> results_;
};

}  // namespace qs::cuda::fast
