// SPDX-License-Identifier: MIT
//
// The counters and look-back words of a frame on the device. They are contiguous, so that the first
// kernel of the frame can set all of them to zero.
#pragma once

#include "raster/cuda/device_buffer.cuh"
#include "raster/cuda/fast/preprocess.cuh"
#include "raster/cuda/fast/radix_sort.cuh"
#include "raster/kernel/tile_grid.h"

namespace qs::cuda::fast {

struct Counters {
  std::uint64_t tile_pairs;  ///< all pairs of the frame
  std::uint32_t listed;      ///< pairs that fit into the buffers
  std::uint32_t visible;
  std::uint32_t max_pairs_in_a_tile;
  std::uint32_t long_lists;
  std::uint32_t segments;  ///< of all long lists
  std::uint32_t turns[2];  ///< half segments that warps have taken: first, and again
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
};

struct FrameSize {
  std::uint32_t gaussians = 0;
  std::uint32_t pair_capacity = 0;     ///< tile pairs that the buffers can hold
  std::uint32_t segment_capacity = 0;  ///< segments of long lists that they can hold
  TileGrid grid;

  /// True if tile indices fit into 16 bits.
  bool uses_16_bit_keys() const { return grid.count() <= 1 << 16; }
};

struct Scratch {
  Counters* counters = nullptr;
  std::uint32_t* depth_digits = nullptr;  ///< number of keys per digit, pass by pass
  std::uint32_t* depth_words = nullptr;   ///< look-back, pass by pass
  std::uint64_t* bin_words = nullptr;     ///< look-back
  std::uint32_t* tile_digits = nullptr;
  std::uint32_t* tile_words = nullptr;
  std::uint32_t* class_sizes = nullptr;  ///< see ScheduleView; null if there are too many tiles
  KeyRange* ranges = nullptr;            ///< per tile: its list in the sorted pairs
  std::uint32_t* schedule = nullptr;     ///< not set to zero
  SegmentsView segments{};               ///< not set to zero

  /// Number of look-back words per pass.
  template <class Key>
  static std::size_t look_back_words(std::uint32_t items) {
    return std::size_t{DeviceCount{nullptr, items}.parts()} * kBins<Key>;
  }

  /// Points the members into the reserved memory. Returns the memory that `project` must clear.
  ToClear begin_frame(const FrameSize& size) {
    std::uint64_t* const base = memory_.data();
    const std::size_t words = lay_out(size, base);
    if (!size.uses_16_bit_keys()) class_sizes = nullptr;
    schedule = schedule_.data();
    segments = {segments_.data(), first_segments_.data(), marks_.data(),
                results_.data(),  size.segment_capacity,  counters};
    return {reinterpret_cast<uint4*>(base), words * sizeof *base / sizeof(uint4)};
  }

  /// Throws Error(device) if memory is short.
  void reserve(const FrameSize& size) {
    memory_.reserve("the frame's counters", lay_out(size, nullptr));
    segments_.reserve("the frame's segments", size.segment_capacity);
    first_segments_.reserve("the frame's segments", size.segment_capacity);
    marks_.reserve("the frame's segments", size.pair_capacity / SegmentsView::kPairsPerMark + 1);
    results_.reserve("the frame's segments", size.segment_capacity);
    if (!size.uses_16_bit_keys()) return;
    schedule_.reserve("the frame's tiles", kWarp * static_cast<std::size_t>(size.grid.count()));
  }

 private:
  /// Points the members into memory from `base` on, unless it is null. Returns the number of 64-bit
  /// words that they occupy.
  std::size_t lay_out(const FrameSize& size, std::uint64_t* base) {
    std::size_t used = 0;
    const auto place = [&]<class T>(T*& what, std::size_t count) {
      constexpr std::size_t kAlign = 16;  // words
      if (base != nullptr) what = reinterpret_cast<T*>(base + used);
      used += (count * sizeof(T) / sizeof *base + kAlign) / kAlign * kAlign;
    };
    using Narrow = std::uint16_t;
    using Wide = std::uint32_t;
    place(counters, 1);
    place(depth_digits, Radix<Wide>::kPasses * kBins<Wide>);
    place(depth_words, Radix<Wide>::kPasses * look_back_words<Wide>(size.gaussians));
    place(bin_words, std::max(1u, blocks_for(size.gaussians)));
    place(tile_digits, Radix<Wide>::kPasses * kBins<Wide>);
    place(tile_words, size.uses_16_bit_keys()
                          ? Radix<Narrow>::kPasses * look_back_words<Narrow>(size.pair_capacity)
                          : Radix<Wide>::kPasses * look_back_words<Wide>(size.pair_capacity));
    place(class_sizes, kWarp);
    place(ranges, static_cast<std::size_t>(size.grid.count()));
    return used;
  }

  DeviceBuffer<std::uint64_t> memory_;
  DeviceBuffer<std::uint32_t> schedule_;
  DeviceBuffer<Segment> segments_;
  DeviceBuffer<std::uint32_t> first_segments_, marks_;
  DeviceBuffer<SegmentResult> results_;
};

}  // namespace qs::cuda::fast
