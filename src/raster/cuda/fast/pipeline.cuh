// SPDX-License-Identifier: MIT
//
// Pipeline `fast`: project -> sort by depth -> bin -> sort by tile -> blend, and color beside the
// middle three. The host waits for nothing before the frame is complete: the stages take the
// numbers of Gaussians and pairs from the device. A frame is one CUDA graph, captured anew for
// every frame, which updates the instance made before, unless its shape has changed. Tile pairs get
// as much room as frames have needed so far. One that needs more says so, and is drawn again with
// more room before anyone sees it.
#pragma once

#include "raster/cuda/fast/blend.cuh"
#include "raster/cuda/fast/graph.cuh"
#include "raster/cuda/stage_clock.cuh"

namespace qs::cuda::fast {

/// Pairs are indexed with 30 bits, see LookBackWord.
inline constexpr std::uint64_t kMaxPairs = (1u << 30) - 1;

class FastPipeline {
 public:
  explicit FastPipeline(int device) : side_(device, false) {}

  /// Fills `pixels` and waits for the frame. Throws Error and Cancelled.
  void draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock);

  /// Statistics, pairs, used pairs and trace of the drawn frame.
  void collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
               Frame& result);

 private:
  void reserve(const FrameSize& size);
  void run(const FrameContext& frame, const FrameSize& size, const Outputs& outputs, Pixels& pixels,
           StageClock& clock, cudaStream_t side);
  void collect_trace(const FrameContext& frame, const std::vector<std::uint32_t>& lengths,
                     Frame& result) const;

  Stream side_;  // of color, which gives way to the rest
  Event projected_, colored_;
  Graph graph_;
  PinnedValue<Counters> counters_;
  Scratch scratch_;
  Visible visible_;
  DepthOrder order_;
  TilePairs pairs_;
  std::uint32_t room_ = 1 << 16;  // for pairs
};

}  // namespace qs::cuda::fast
