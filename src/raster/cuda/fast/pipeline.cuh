// SPDX-License-Identifier: MIT
//
// Pipeline `fast`: project -> list by macro-tile -> blend, with `color` running concurrently with
// listing, and long lists blended concurrently with the others. Views with very full macro-tiles
// take project -> sort by depth -> bin -> sort by tile -> blend instead, with equal lists. The host
// does not wait before the frame is complete: stages read the numbers of Gaussians and pairs on the
// device. Every frame is captured as a CUDA graph, which updates the previous instance unless the
// topology has changed. The buffers for tile pairs, macro-tiles and segments of long lists have the
// capacity that earlier frames needed. A frame that exceeds it is detected, and redrawn with larger
// buffers before anyone reads it.
#pragma once

#include "raster/cuda/collect.cuh"
#include "raster/cuda/fast/blend.cuh"
#include "raster/cuda/fast/graph.cuh"
#include "raster/cuda/stage_clock.cuh"

namespace qs::cuda::fast {

/// Pairs are indexed with 30 bits, see LookBackWord::kValue.
inline constexpr std::uint64_t kMaxPairs = (1u << 30) - 1;

/// px^2. Blending multiplies exponentials whose exponents grow as footprints become thinner. With
/// this dilation they stay above -90, and floats reach down to -126.
inline constexpr double kLeastDilation = kDilation / 2;

/// Chooses FrameSize::macro_capacity from the previous frame.
class MacroTileCapacity {
 public:
  static constexpr std::uint32_t kFirst = MacroTiles::kUsual;
  static constexpr std::size_t kMostMacroTiles = 8160;  ///< of 7680 x 4352 pixels

  /// `most`: the largest possible capacity.
  explicit MacroTileCapacity(std::uint32_t most) : most_(most) {}

  /// The largest capacity for frames of this size that shared memory and a gigabyte of device
  /// memory allow.
  std::uint32_t most_for(const FrameSize& size) const;

  /// For the frame after one of this size with these counters, or for the same frame again. 0: sort
  /// it globally, because no capacity suffices.
  std::uint32_t next(const Counters& counters, const FrameSize& size);

 private:
  std::uint32_t most_;
  std::uint32_t longest_list_ = 0;  // of a tile in the view that was too full
};

class FastPipeline {
 public:
  explicit FastPipeline(int device);

  /// Fills `pixels` and waits for the frame. Throws Error and Cancelled.
  void draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock);

  /// Fills statistics, pairs, used pairs and trace of the drawn frame, as requested.
  void collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
               Frame& result);

 private:
  void reserve(const FrameSize& size);
  void run(const FrameContext& frame, const FrameSize& size, const Outputs& outputs, Pixels& pixels,
           StageClock& clock, cudaStream_t side_stream);
  std::vector<ListRange> list_ranges(const FrameContext& frame) const;
  void append_gaussians(const FrameContext& frame, Trace& trace) const;

  Stream side_stream_;  // low priority: its kernels yield to the main stream
  Stream full_stream_;  // for full macro-tiles
  Event projected_, listed_, colored_, scheduled_, blended_;
  Graph graph_;
  PinnedValue<Counters> counters_;
  Scratch scratch_;
  Visible visible_;
  DepthOrder order_;
  TilePairs pairs_;
  MacroTileCapacity macro_capacity_;
  FrameSize size_;  // of the previous frame, with the capacities for the next
};

}  // namespace qs::cuda::fast
