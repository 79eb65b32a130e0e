// SPDX-License-Identifier: MIT
//
// What a frame counts and marks on the device. It lies in one piece of memory, which the frame's
// first kernel makes zero.
#pragma once

#include "raster/cuda/device_buffer.cuh"
#include "raster/cuda/fast/preprocess.cuh"
#include "raster/cuda/fast/radix_sort.cuh"
#include "raster/kernel/tile_grid.h"

namespace qs::cuda::fast {

struct Counters {
  std::uint64_t tile_pairs;  ///< of the frame
  std::uint32_t listed;      ///< those that had room
  std::uint32_t visible;
  std::uint32_t max_pairs_in_a_tile;
};

/// How large a frame is.
struct FrameSize {
  std::uint32_t gaussians = 0;
  std::uint32_t pairs = 0;  ///< room for so many
  TileGrid grid;

  /// Tile indices fit into 16 bits.
  bool narrow() const { return grid.count() <= 1 << 16; }
};

struct Scratch {
  Counters* counters = nullptr;
  std::uint32_t* depth_digits = nullptr;  ///< how many keys have a digit, pass by pass
  std::uint32_t* depth_words = nullptr;   ///< look-back, pass by pass
  std::uint64_t* bin_words = nullptr;     ///< look-back
  std::uint32_t* tile_digits = nullptr;
  std::uint32_t* tile_words = nullptr;
  std::uint32_t* class_sizes = nullptr;  ///< see ScheduleView; null where tiles are too many
  KeyRange* ranges = nullptr;            ///< per tile: where its list lies among the sorted pairs
  std::uint32_t* schedule = nullptr;     ///< not made zero

  /// Words of one pass.
  template <class Key>
  static std::size_t look_back_words(std::uint32_t items) {
    return std::size_t{DeviceCount{nullptr, items}.parts()} * kBins<Key>;
  }

  /// Finds room for a frame of this size; `project` must make it zero.
  ToClear begin(const FrameSize& size) {
    std::uint64_t* const base = memory_.data();
    const std::size_t words = lay_out(size, base);
    if (!size.narrow()) class_sizes = nullptr;
    schedule = schedule_.data();
    return {reinterpret_cast<uint4*>(base), words * sizeof *base / sizeof(uint4)};
  }

  /// Throws Error(device) when memory is short.
  void reserve(const FrameSize& size) {
    memory_.reserve("the frame's counters", lay_out(size, nullptr));
    if (!size.narrow()) return;
    schedule_.reserve("the frame's tiles", kWarp * static_cast<std::size_t>(size.grid.count()));
  }

 private:
  /// Places everything from `base` on; how many 64-bit words that takes.
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
    place(tile_words, size.narrow() ? Radix<Narrow>::kPasses * look_back_words<Narrow>(size.pairs)
                                    : Radix<Wide>::kPasses * look_back_words<Wide>(size.pairs));
    place(class_sizes, kWarp);
    place(ranges, static_cast<std::size_t>(size.grid.count()));
    return used;
  }

  DeviceBuffer<std::uint64_t> memory_;
  DeviceBuffer<std::uint32_t> schedule_;
};

}  // namespace qs::cuda::fast
