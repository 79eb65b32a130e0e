// SPDX-License-Identifier: MIT
//
// Pipeline `fast`: project -> sort by depth -> bin -> sort by tile -> blend, with `color` running
// concurrently with the middle three, and long lists blended concurrently with the others. The host
// does not wait before the frame is complete: stages read the numbers of Gaussians and pairs on the
// device. Every frame is captured as a CUDA graph, which updates the previous instance unless the
// topology has changed. The buffers for tile pairs and segments of long lists keep the capacity
// that earlier frames needed. A frame that exceeds it is detected, and redrawn with larger buffers
// before anyone reads it.
#pragma once

#include "raster/cuda/fast/blend.cuh"
#include "raster/cuda/fast/graph.cuh"
#include "raster/cuda/stage_clock.cuh"

namespace qs::cuda::fast {

/// Pairs are indexed with 30 bits, see LookBackWord::kValue.
inline constexpr std::uint64_t kMaxPairs = (1u << 30) - 1;

/// px^2. Blending multiplies exponentials whose exponents grow as footprints become thinner. With
/// this dilation they stay above -90, and floats reach down to -126.
inline constexpr double kLeastDilation = kDilation / 2;

class FastPipeline {
 public:
  explicit FastPipeline(int device) : side_stream_(device, false) {}

  /// Fills `pixels` and waits for the frame. Throws Error and Cancelled.
  void draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock);

  /// Fills statistics, pairs, used pairs and trace of the drawn frame, as requested.
  void collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
               Frame& result);

 private:
  void reserve(const FrameSize& size);
  void run(const FrameContext& frame, const FrameSize& size, const Outputs& outputs, Pixels& pixels,
           StageClock& clock, cudaStream_t side_stream);
  std::vector<std::uint32_t> list_lengths(const FrameContext& frame) const;
  void append_gaussians(const FrameContext& frame, Trace& trace) const;

  Stream side_stream_;  // low priority: its kernels yield to the main stream
  Event projected_, colored_, scheduled_, blended_;
  Graph graph_;
  PinnedValue<Counters> counters_;
  Scratch scratch_;
  Visible visible_;
  DepthOrder order_;
  TilePairs pairs_;
  std::uint32_t pair_capacity_ = 1 << 16, segment_capacity_ = 1 << 5;
};

}  // namespace qs::cuda::fast
