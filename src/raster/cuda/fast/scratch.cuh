// SPDX-License-Identifier: MIT
//
// The counters, macro-tiles and segments of a frame on the device. The memory that must be zero
// when the frame begins is contiguous.
#pragma once

#include "raster/cuda/common/pixels.cuh"
#include "raster/cuda/common/sub_tiles.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/cuda/fast/macro_tiles.cuh"

namespace qs::cuda::fast {

struct FastCounters {
  std::uint64_t tile_pairs;  ///< all pairs of the frame
  std::uint32_t visible;
  std::uint32_t visible_blocks;  ///< see FastVisibleView
  std::uint32_t max_pairs_in_a_tile;
  std::uint32_t long_lists;
  std::uint32_t segments;            ///< segments of all long lists, as reserved
  std::uint32_t cut_segments;        ///< as cut
  std::uint32_t turns[2];            ///< half segments that warps have taken: first, and again
  std::uint32_t entries;             ///< entries of all macro-tiles
  std::uint32_t fullest_macro_tile;  ///< Gaussians in it
  std::uint32_t full_macro_tiles;    ///< number of them
  std::uint32_t spilled;             ///< entries in the fullest of Slicing::kParts
  std::uint32_t slices;              ///< slices of all full macro-tiles
  std::uint32_t fullest_slice;       ///< entries in it
  std::uint32_t large;               ///< visible Gaussians that are too large for Appended
  std::uint32_t blocks_done;         ///< blocks that have finished appending large Gaussians
  std::uint32_t cut_blocks_done;     ///< blocks that have finished cutting segments
};

/// A part of a long list. The segments of a list are adjacent. Arrays have an element for each half
/// of the tile.
struct Segment {
  static constexpr std::uint32_t kNoTile = 0xffffffffu;  ///< its list exceeds the buffers
  std::uint32_t tile, number;
  std::uint32_t samples;     ///< in this part of the list, see LongList
  std::uint32_t count;       ///< segments of the list; only the first segment has it
  std::uint32_t begin, end;  ///< pairs
  std::uint32_t slot;        ///< in its wave, see WavesView
  /// 1 if the segment's SegmentResult is complete.
  std::uint32_t finished[kHalfTiles];
  /// SegmentResult::front allows for the segments with lower numbers.
  std::uint32_t front_end[kHalfTiles];
};

/// The result of compositing a segment, per pixel of the tile. A pixel that stops in the segment
/// has transmittance 0, and its colour allows for the segments in front; other colours do not.
struct SegmentResult {
  float red[kTileSize * kTileSize], green[kTileSize * kTileSize], blue[kTileSize * kTileSize];
  float transmittance[kTileSize * kTileSize];
  float front[kTileSize * kTileSize];  ///< product of the transmittances of the first segments
};

inline constexpr std::uint32_t kMaxSegments = 256;  ///< segments of a list, at most

/// Segments are composited wave by wave: wave n has the segments number n of all long lists.
struct WavesView {
  std::uint32_t* sizes;  ///< kMaxSegments; later the first turns of the waves
  std::uint32_t* order;  ///< per turn: a segment
};

struct SegmentsView {
  Segment* segments;
  std::uint32_t* first_segments;  ///< per long list
  std::uint32_t* marks;  ///< a bit per pair of the long lists: the pair is a sample, see LongList
  SegmentResult* results;
  WavesView waves;
  std::uint32_t capacity;
  std::uint32_t longest_uncut;  ///< in pairs; longer lists have segments
  FastCounters* counters;

  /// Lists are cut earlier in a small picture, whose tiles are too few to occupy the GPU while one
  /// warp walks through a list. Cutting costs about 60 us a frame, too much for a few lists.
  static std::uint32_t longest_uncut_of(TileGrid grid) {
    constexpr int kSmall = 4000;  // tiles
    return grid.count() < kSmall ? 768 : 8192;
  }

  /// The bits of a list that begins at pair p begin in word p / kPairsPerMark. A word has twice as
  /// many bits, so long lists leave room behind their last word and share none.
  static constexpr std::uint32_t kPairsPerMark = 16;

  /// Reserves `count` adjacent segments for the long list of a tile.
  __device__ void reserve(std::uint32_t tile, std::uint32_t count) const {
    const std::uint32_t first = atomicAdd(&counters->segments, count);
    const bool fits = first + count <= capacity;
    for (std::uint32_t i = 0; i < count && first + i < capacity; ++i)
      segments[first + i] = {fits ? tile : Segment::kNoTile, i};
    const std::uint32_t list = atomicAdd(&counters->long_lists, 1u);
    if (list < capacity) first_segments[list] = first;
  }
};

struct FrameSize {
  std::uint32_t gaussians = 0;
  std::uint32_t pair_capacity = 0;     ///< tile pairs that the buffers can hold
  std::uint32_t segment_capacity = 0;  ///< segments that they can hold; 0: no list is cut
  MacroSize macro;
  TileGrid grid;

  std::size_t macro_tiles() const { return MacroTiles::count_of(grid); }
};

/// Memory that must be set to zero.
struct ToClear {
  std::uint64_t* begin;
  std::size_t words;
};

struct Scratch {
  FastCounters* counters = nullptr;
  MacroTiles macro_tiles{};
  std::uint32_t* class_sizes = nullptr;  ///< see ScheduleView
  // Not set to zero:
  ListRange* ranges = nullptr;        ///< per tile: its list in the tile pairs
  std::uint32_t* schedule = nullptr;  ///< see ScheduleView
  SegmentsView segments{};
  std::uint32_t* large = nullptr;  ///< places of FastCounters::large Gaussians

  /// Points the members into the reserved memory. Returns the memory that must be cleared first.
  ToClear begin_frame(const FrameSize& size) {
    const Layout layout = lay_out(size, memory_.data());
    segments.capacity = size.segment_capacity;
    segments.longest_uncut = SegmentsView::longest_uncut_of(size.grid);
    segments.counters = counters;
    segments.waves.sizes = wave_sizes_;
    macro_tiles.columns = MacroTiles::columns_of(size.grid);
    macro_tiles.rows = MacroTiles::rows_of(size.grid);
    macro_tiles.slicing.size = size.macro;
    for_each_array(
        size, [](const char*, auto& buffer, auto*& array, std::size_t) { array = buffer.data(); });
    return {memory_.data(), layout.cleared};
  }

  /// Throws Error(device) if memory is short.
  void reserve(const FrameSize& size) {
    memory_.reserve(kCounters, lay_out(size, nullptr).used);
    for_each_array(size, [](const char* what, auto& buffer, auto*&, std::size_t count) {
      buffer.reserve(what, count);
    });
  }

 private:
  static constexpr const char* kCounters = "the frame's counters";

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
    place(counters, 1);
    place(class_sizes, kWarp);
    place(wave_sizes_, size.segment_capacity > 0 ? kMaxSegments : 0);
    place(macro_tiles.counts, size.macro_tiles());
    place(macro_tiles.slicing.part_counts, Slicing::counters());
    const std::size_t cleared = used;
    place(ranges, static_cast<std::size_t>(size.grid.count()));
    return {cleared, used};
  }

  /// Calls visit(what, buffer, array, count) for the buffers outside of `memory_`. `array` is the
  /// member through which kernels see the buffer, and `count` its elements in a frame of `size`.
  template <class Visit>
  void for_each_array(const FrameSize& size, const Visit& visit) {
    constexpr const char *kSegments = "the frame's segments", *kSlices = "the frame's slices";
    constexpr const char* kMacroTiles = "the frame's macro-tiles";
    const std::size_t macro_count = size.macro_tiles();
    const MacroSize& macro = size.macro;
    visit(kCounters, schedule_, schedule, kWarp * static_cast<std::size_t>(size.grid.count()));
    visit(kSegments, segments_, segments.segments, size.segment_capacity);
    visit(kSegments, first_segments_, segments.first_segments, size.segment_capacity);
    visit(kSegments, marks_, segments.marks, size.pair_capacity / SegmentsView::kPairsPerMark + 1);
    visit(kSegments, results_, segments.results, size.segment_capacity);
    visit(kSegments, waves_, segments.waves.order, size.segment_capacity);
    visit("the frame's Gaussians", large_, large, size.gaussians);
    visit(kMacroTiles, entries_, macro_tiles.entries, macro_count * macro.capacity);
    visit(kMacroTiles, masks_, macro_tiles.masks, macro_count * macro.capacity);
    visit(kMacroTiles, order_, macro_tiles.order, macro_count);
    if (!macro.has_slices()) return;
    Slicing& slicing = macro_tiles.slicing;
    const std::size_t slice_entries = std::size_t{macro.slices} * macro.slice_capacity;
    const std::size_t spilled = std::size_t{Slicing::kParts} * macro.spilled;
    visit(kMacroTiles, slices_, slicing.slices, macro_count);
    visit(kMacroTiles, samples_, slicing.samples, macro_count * macro.sample_capacity);
    if (macro.sorts_in_global_memory) {
      visit(kSlices, sort_memory_, slicing.sort_memory,
            Slicing::kGlobalSorts * Slicing::sort_bytes(macro.sample_capacity));
    }
    visit(kSlices, spilled_, slicing.spilled, spilled);
    visit(kSlices, spilled_tiles_, slicing.spilled_tiles, spilled);
    visit(kSlices, macro_tile_of_, slicing.macro_tile_of, macro.slices);
    visit(kSlices, least_keys_, slicing.least_keys, macro.slices);
    visit(kSlices, slice_counts_, slicing.counts, macro.slices);
    visit(kSlices, list_begins_, slicing.list_begins,
          std::size_t{macro.slices} * MacroTiles::kTiles);
    visit(kSlices, slice_entries_, slicing.entries, slice_entries);
    visit(kSlices, slice_masks_, slicing.masks, slice_entries);
  }

  std::uint32_t* wave_sizes_ = nullptr;  // set to zero, see WavesView
  DeviceBuffer<std::uint64_t> memory_;
  DeviceBuffer<std::uint32_t> schedule_;
  DeviceBuffer<Segment> segments_;
  DeviceBuffer<std::uint32_t> first_segments_, marks_, waves_;
  DeviceBuffer<SegmentResult> results_;
  DeviceBuffer<std::uint32_t> large_, order_;
  DeviceBuffer<SortEntry> entries_, spilled_, samples_, slice_entries_;
  DeviceBuffer<std::uint8_t> masks_, slice_masks_;
  DeviceBuffer<Slicing::Slices> slices_;
  DeviceBuffer<std::uint32_t> spilled_tiles_, macro_tile_of_, slice_counts_;
  DeviceBuffer<std::uint64_t> least_keys_, list_begins_;
  DeviceBuffer<std::byte> sort_memory_;
};

}  // namespace qs::cuda::fast
