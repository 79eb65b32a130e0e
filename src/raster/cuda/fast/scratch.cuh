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
#include "raster/cuda/fast/occlusion.cuh"

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
  std::uint64_t tile_pairs;  ///< all pairs of the frame, or of a slab
  std::uint32_t visible;
  std::uint32_t visible_blocks;  ///< see FastVisible
  std::uint32_t shown_blocks;    ///< FastVisible::shown, of all slabs
  std::uint64_t sampled_tiles;   ///< see CutRule
  std::uint32_t max_pairs_in_a_tile;
  std::uint32_t longest_samples;     ///< of a list that is cut
  std::uint32_t segments;            ///< segments of all long lists
  std::uint32_t turns;               ///< half segments that warps have taken
  std::uint32_t entries;             ///< entries of all macro-tiles
  std::uint32_t fullest_macro_tile;  ///< Gaussians in it
  std::uint32_t full_macro_tiles;    ///< number of them
  std::uint32_t spilled;             ///< entries in the fullest of Slicing::kParts
  std::uint32_t slices;              ///< slices of all full macro-tiles
  std::uint32_t fullest_slice;       ///< entries in it
  std::uint32_t large;               ///< visible Gaussians that are too large for Appended
  std::uint32_t blocks_done;         ///< blocks that have finished appending large Gaussians
};

/// The progress of half a segment, as other warps see it.
enum class SegmentState : std::uint32_t {
  waiting,
  composited,  ///< SegmentResult::transmittance is known
  known        ///< SegmentResult::behind too
};

/// A part of a long list. The segments of a list are adjacent. Arrays have an element for each half
/// of the tile.
struct Segment {
  std::uint32_t tile, number;
  std::uint32_t count;              ///< segments of the list
  std::uint32_t begin;              ///< first pair; the next segment's begin is the end
  std::uint32_t state[kHalfTiles];  ///< SegmentState
  std::uint32_t ended[kHalfTiles];  ///< segments of the group that begins here which have ended
  std::uint32_t each;               ///< samples in it
  // Of the first segment of a list alone:
  std::uint32_t groups_ended[kHalfTiles];
  std::uint32_t stopped[kHalfTiles];  ///< in front of this segment all pixels have stopped
};

/// The result of compositing a segment, per pixel of the tile. Colours allow for the segments in
/// front.
struct SegmentResult {
  static constexpr int kPixels = kTileSize * kTileSize;

  float red[kPixels], green[kPixels], blue[kPixels];
  float transmittance[kPixels];  ///< of the segment alone
  float behind[kPixels];         ///< product of the transmittances up to this segment
};

struct SegmentsView {
  static constexpr std::uint32_t kUncut = 0xffffffffu;

  Segment* segments;
  SegmentResult* results;
  std::uint32_t*
      first_segments;          ///< per tile: of its list; kUncut: one warp walks through the list
  std::uint32_t* queue_sizes;  ///< see ScheduleView; classes of numbers, the lowest first
  std::uint32_t* queue;
  std::uint32_t capacity;
  bool finds_samples;
  std::uint32_t least, each;  ///< CutRule, if not 0
  FastCounters* counters;

  /// False if no list of the frame is long enough: then all are drawn as if they were not cut.
  __device__ bool are_used() const;
};

struct FrameSize {
  std::uint32_t gaussians = 0;
  std::uint32_t pair_capacity = 0;       ///< tile pairs that the buffers can hold
  std::uint32_t segment_capacity = 256;  ///< segments that they can hold
  bool finds_samples = false;            ///< listing finds the samples of long lists
  bool blends_segments = false;          ///< the frame has the kernel for long lists
  MacroSize macro;
  TileGrid grid;
  int width = 0, height = 0;  ///< px
  unsigned slabs = 1;         ///< see OcclusionView

  std::size_t macro_tiles() const { return MacroTiles::count_of(grid); }
};

struct Scratch {
  explicit Scratch(unsigned multiprocessors_) : multiprocessors(multiprocessors_) {}

  unsigned multiprocessors;                 ///< of the GPU
  FrameSize size;                           ///< size of the frame
  std::span<std::uint64_t> to_clear;        ///< memory that must be zero when the frame begins
  std::span<std::uint64_t> to_clear_again;  ///< the part for later slabs
  FastCounters* counters = nullptr;         ///< of each slab
  OcclusionView occlusion{};
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
    segments.finds_samples = size.finds_samples;
    segments.counters = counters;
    occlusion.columns = MacroTiles::columns_of(size.grid);
    occlusion.width = size.width;
    occlusion.height = size.height;
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
    place(counters, size.slabs);
    place(occlusion.histogram, OcclusionView::kBins);
    place(occlusion.stopped, size.macro_tiles());
    const std::size_t once = used;
    place(class_sizes, kWarp);
    place(segments.queue_sizes, kWarp);
    place(macro_tiles.counts, size.macro_tiles());
    place(macro_tiles.slicing.part_counts, Slicing::counters());
    if (base != nullptr) {
      to_clear = {base, used};
      to_clear_again = {base + once, used - once};
    }
    place(occlusion.borders, OcclusionView::kMostSlabs + 1);
    place(ranges, static_cast<std::size_t>(size.grid.count()));
    place(segments.first_segments, static_cast<std::size_t>(size.grid.count()));
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
    visit(kSegments, segments.results, size.segment_capacity);
    visit(kSegments, segments.queue, kWarp * std::size_t{size.segment_capacity});
    visit(kOf, large, size.gaussians);
    visit(kOf, occlusion.depths, size.slabs > 1 ? blocks_for(size.gaussians) : 0);
    visit(kOf, occlusion.transmittance,
          size.slabs > 1
              ? static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height)
              : 0);
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
    visit(kSlices, slicing.sample_begins, std::size_t{macro.slices} * MacroTiles::kTiles);
    visit(kSlices, slicing.entries, slice_entries);
    visit(kSlices, slicing.masks, slice_entries);
    if (macro.sorts_in_global_memory)
      visit(kSlices, slicing.sort_memory,
            Slicing::kGlobalSorts * Slicing::sort_bytes(macro.sample_capacity));
  }

  DeviceBuffer<std::uint64_t> memory_;
  std::array<DeviceBuffer<std::byte>, 28> buffers_;  // of for_each_array()
};

}  // namespace qs::cuda::fast
