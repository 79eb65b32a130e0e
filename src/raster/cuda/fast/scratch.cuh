// SPDX-License-Identifier: MIT
//
// What a frame counts and marks on the device. It lies in one piece of memory, so that one memset
// makes all of it zero before the frame.
#pragma once

#include "raster/cuda/device_buffer.cuh"
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
  std::uint32_t* schedule = nullptr;  ///< tiles in the order in which they are blended
  KeyRange* ranges = nullptr;         ///< per tile: where its list lies among the sorted pairs

  /// Words of one pass.
  template <class Key>
  static std::size_t look_back_words(std::uint32_t items) {
    return std::size_t{DeviceCount{nullptr, items}.parts()} * kBins<Key>;
  }

  /// Finds room for a frame of this size and makes it zero, in the order of the stream.
  void begin(const FrameSize& size, cudaStream_t stream) {
    std::uint64_t* const base = memory_.data();
    check(cudaMemsetAsync(base, 0, lay_out(size, base) * sizeof *base, stream), "frame");
  }

  /// Throws Error(device) when memory is short.
  void reserve(const FrameSize& size) {
    memory_.reserve("the frame's counters", lay_out(size, nullptr));
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
    place(bin_words, blocks_for(size.gaussians) + std::size_t{1});
    place(tile_digits, Radix<Wide>::kPasses * kBins<Wide>);
    place(tile_words, size.narrow() ? Radix<Narrow>::kPasses * look_back_words<Narrow>(size.pairs)
                                    : Radix<Wide>::kPasses * look_back_words<Wide>(size.pairs));
    place(schedule, static_cast<std::size_t>(size.grid.count()));
    place(ranges, static_cast<std::size_t>(size.grid.count()));
    return used;
  }

  DeviceBuffer<std::uint64_t> memory_;
};

}  // namespace qs::cuda::fast
