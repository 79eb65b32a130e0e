// SPDX-License-Identifier: MIT
//
// The memory of a frame on the device: its visible Gaussians, counters, macro-tiles, lists and
// segments. The memory that must be zero when the frame begins is contiguous.
#pragma once

#include <array>
#include <bit>
#include <span>

#include "raster/cuda/common/pixels.cuh"
#include "raster/cuda/common/sub_tiles.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/cuda/fast/macro_tiles.cuh"

namespace qs::cuda::fast {

/// A visible Gaussian as `color` reads it: 32 bytes, one memory sector. footprint() recomputes the
/// other values bit for bit.
struct alignas(32) PackedFootprint {
  glm::vec2 mean_px;
  Covariance2<float> covariance;
  float gamma;
  glm::vec2 unused;  ///< written too, because a partly written sector is first read

  QS_HD Footprint footprint() const { return make_footprint(mean_px, covariance, gamma); }
};

/// A Gaussian as the blend kernel reads it: 64 bytes, two memory sectors.
struct alignas(64) BoundedSplat {
  float x, y;          ///< mean_px
  float xx, xy, yy;    ///< log2 alpha = log2_opacity + xx dx^2 + xy dx dy + yy dy^2
  float log2_opacity;  ///< -inf for opacity 0
  /// alpha can exceed kAlphaMax only in rows within this distance of the mean; < 0: in no row;
  /// INFINITY: rounding may have broken the conic
  float clamp_rows;
  float red, green, blue;  ///< >= 0
  AlphaEllipse ellipse;
  float unused;

  Splat splat() const {
    return {{x, y}, {xx, xy, yy}, std::exp2(log2_opacity), {red, green, blue}};
  }
};

/// A depth key is the bit pattern of the depth minus the bit pattern of the near plane. Positive
/// floats are ordered like their bit patterns.
inline constexpr std::uint32_t kInvisibleKey = 0xffffffffu;

inline std::uint32_t nearest_bits(const Camera& camera) {
  return std::bit_cast<std::uint32_t>(std::max(static_cast<float>(camera.near_depth), 0.0f));
}
inline float depth_of_key(std::uint32_t key, const Camera& camera) {
  return std::bit_cast<float>(key + nearest_bits(camera));
}

/// The pointers that kernels use. Passed by value.
struct FastVisible {
  std::uint8_t* shown;    ///< per block of Gaussians: 0 if the view cannot show any of them
  std::uint32_t* blocks;  ///< the blocks with visible Gaussians, in any order
  /// per place in these blocks; kInvisibleKey = not visible, and the other arrays are undefined
  /// there
  std::uint32_t* depth_keys;
  PackedFootprint* footprints;
  BoundedSplat* splats;
};

using ListInput = BlendInput<BoundedSplat>;

struct FastCounters {
  std::uint64_t tile_pairs;  ///< all pairs of the frame
  std::uint32_t visible;
  std::uint32_t visible_blocks;  ///< see FastVisible
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

struct Scratch {
  explicit Scratch(unsigned multiprocessors_) : multiprocessors(multiprocessors_) {}

  unsigned multiprocessors;           ///< of the GPU
  FrameSize size;                     ///< size of the frame
  std::span<std::uint64_t> to_clear;  ///< memory that must be zero when the frame begins
  FastCounters* counters = nullptr;
  MacroTiles macro_tiles{};
  std::uint32_t* class_sizes = nullptr;  ///< see ScheduleView
  // Not set to zero:
  FastVisible visible{};
  ListRange* ranges = nullptr;         ///< per tile: its list in the tile pairs
  std::uint32_t* gaussians = nullptr;  ///< the lists of all tiles, front to back: places
  std::uint32_t* schedule = nullptr;   ///< see ScheduleView
  SegmentsView segments{};
  std::uint32_t* large = nullptr;  ///< places of FastCounters::large Gaussians

  ListInput lists(const FrameContext& frame) const {
    return ListInput::of(frame, ranges, gaussians, visible.splats);
  }

  /// Makes room for a frame, and points the members into the memory. Throws Error(device) if memory
  /// is short.
  void reserve(const FrameSize& frame) {
    size = frame;
    memory_.reserve(kCounters, lay_out(nullptr));
    lay_out(memory_.data());
    std::size_t next = 0;
    for_each_array([&]<class T>(const char* what, T*& array, std::size_t count) {
      DeviceBuffer<std::byte>& buffer = buffers_[next++];
      buffer.reserve(what, count * sizeof(T));
      array = reinterpret_cast<T*>(buffer.data());
    });
    segments.capacity = size.segment_capacity;
    segments.longest_uncut = SegmentsView::longest_uncut_of(size.grid);
    segments.counters = counters;
    macro_tiles.columns = MacroTiles::columns_of(size.grid);
    macro_tiles.rows = MacroTiles::rows_of(size.grid);
    macro_tiles.slicing.size = size.macro;
  }

 private:
  static constexpr const char* kCounters = "the frame's counters";

  /// Points members into memory from `base` on, unless it is null. Returns the 64-bit words that
  /// they take.
  std::size_t lay_out(std::uint64_t* base) {
    std::size_t used = 0;
    const auto place = [&]<class T>(T*& what, std::size_t count) {
      constexpr std::size_t kAlign = 16;  // words
      if (base != nullptr) what = reinterpret_cast<T*>(base + used);
      used += (count * sizeof(T) / sizeof *base + kAlign) / kAlign * kAlign;
    };
    place(counters, 1);
    place(class_sizes, kWarp);
    place(segments.waves.sizes, size.segment_capacity > 0 ? kMaxSegments : 0);
    place(macro_tiles.counts, size.macro_tiles());
    place(macro_tiles.slicing.part_counts, Slicing::counters());
    if (base != nullptr) to_clear = {base, used};
    place(ranges, static_cast<std::size_t>(size.grid.count()));
    return used;
  }

  /// Calls visit(what, array, count) for the arrays outside of `memory_`, always in this order.
  template <class Visit>
  void for_each_array(const Visit& visit) {
    constexpr const char *kSegments = "the frame's segments", *kSlices = "the frame's slices";
    constexpr const char *kMacroTiles = "the frame's macro-tiles", *kOf = "the frame's Gaussians";
    const std::size_t macro_count = size.macro_tiles();
    const MacroSize& macro = size.macro;
    visit(kOf, visible.shown, blocks_for(size.gaussians));
    visit(kOf, visible.blocks, blocks_for(size.gaussians));
    visit(kOf, visible.depth_keys, size.gaussians);
    visit(kOf, visible.footprints, size.gaussians);
    visit(kOf, visible.splats, size.gaussians);
    visit("the frame's tile pairs", gaussians, size.pair_capacity);
    visit(kCounters, schedule, kWarp * static_cast<std::size_t>(size.grid.count()));
    visit(kSegments, segments.segments, size.segment_capacity);
    visit(kSegments, segments.first_segments, size.segment_capacity);
    visit(kSegments, segments.marks, size.pair_capacity / SegmentsView::kPairsPerMark + 1);
    visit(kSegments, segments.results, size.segment_capacity);
    visit(kSegments, segments.waves.order, size.segment_capacity);
    visit(kOf, large, size.gaussians);
    visit(kMacroTiles, macro_tiles.entries, macro_count * macro.capacity);
    visit(kMacroTiles, macro_tiles.masks, macro_count * macro.capacity);
    visit(kMacroTiles, macro_tiles.order, macro_count);
    if (!macro.has_slices()) return;
    Slicing& slicing = macro_tiles.slicing;
    const std::size_t slice_entries = std::size_t{macro.slices} * macro.slice_capacity;
    const std::size_t spilled = std::size_t{Slicing::kParts} * macro.spilled;
    visit(kMacroTiles, slicing.slices, macro_count);
    visit(kMacroTiles, slicing.samples, macro_count * macro.sample_capacity);
    visit(kSlices, slicing.spilled, spilled);
    visit(kSlices, slicing.spilled_tiles, spilled);
    visit(kSlices, slicing.macro_tile_of, macro.slices);
    visit(kSlices, slicing.least_keys, macro.slices);
    visit(kSlices, slicing.counts, macro.slices);
    visit(kSlices, slicing.list_begins, std::size_t{macro.slices} * MacroTiles::kTiles);
    visit(kSlices, slicing.entries, slice_entries);
    visit(kSlices, slicing.masks, slice_entries);
    if (macro.sorts_in_global_memory)
      visit(kSlices, slicing.sort_memory,
            Slicing::kGlobalSorts * Slicing::sort_bytes(macro.sample_capacity));
  }

  DeviceBuffer<std::uint64_t> memory_;
  std::array<DeviceBuffer<std::byte>, 27> buffers_;  // of for_each_array()
};

}  // namespace qs::cuda::fast
