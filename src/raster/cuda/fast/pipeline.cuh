// SPDX-License-Identifier: MIT
//
// Pipeline `fast`: project -> list -> blend, with `color` running concurrently with listing, and
// long lists blended concurrently with the others. The host does not wait before the frame is
// complete: stages read the numbers of Gaussians and pairs on the device. Every frame is captured
// as a CUDA graph, which updates the previous instance unless the topology has changed. The buffers
// have the capacities that earlier frames needed. A frame that exceeds a capacity is detected, and
// redrawn with larger buffers before its pixels are read.
#pragma once

#include <optional>

#include "raster/cuda/common/pixels.cuh"
#include "raster/cuda/common/stage_clock.cuh"
#include "raster/cuda/fast/graph.cuh"
#include "raster/cuda/fast/stages.cuh"

namespace qs::cuda::fast {

/// Chooses FrameSize::macro from the counters of the previous frame.
class MacroSizePolicy {
 public:
  /// `most`: see most_in_shared_memory().
  explicit MacroSizePolicy(std::uint32_t most) : most_(most) {}

  /// True if a frame of this size with these counters listed all its Gaussians.
  static bool fits(const FastCounters& counters, const MacroSize& size);

  /// Size for the frame after a frame of `size` with these counters, or for drawing that frame
  /// again. Unset if no size can draw this view.
  std::optional<MacroSize> next(const FastCounters& counters, const FrameSize& size) const;

 private:
  std::optional<MacroSize> sliced(const FastCounters& counters, const MacroSize& before) const;

  std::uint32_t most_;
};

class FastPipeline {
 public:
  explicit FastPipeline(int device);

  /// False for pictures of more than MacroTiles::kMost macro-tiles.
  static bool can_draw(TileGrid grid);

  /// Draws a scene in Order::space. Fills `pixels` and waits for the frame. Returns false if the
  /// slices of a macro-tile do not fit, because its samples were not representative. Throws Error
  /// and Cancelled.
  bool draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock);

  /// Fills statistics, pairs, used pairs and trace of the drawn frame, as requested.
  void collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
               Frame& result);

  /// Enqueues a pass that fills Pixels::depth of the drawn frame.
  void draw_depth(const FrameContext& frame, Pixels& pixels);

 private:
  void run(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock,
           cudaStream_t side_stream);
  void append_gaussians(const FrameContext& frame, Trace& trace) const;

  Stream side_stream_;  // low priority: its kernels yield to the main stream
  Stream full_stream_;  // for full macro-tiles
  Event footprints_known_, projected_, listed_, colored_, scheduled_, blended_;
  Graph graph_;
  PinnedValue<FastCounters> counters_;
  Scratch scratch_;
  DeviceBuffer<float> depths_;  // by place, for draw_depth()
  MacroSizePolicy macro_size_policy_;
  FrameSize size_;  // of the previous frame, with the capacities for the next
};

}  // namespace qs::cuda::fast
