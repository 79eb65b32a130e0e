// SPDX-License-Identifier: MIT
//
// Pipeline `fast`: project -> list -> blend, with `color` running concurrently with listing, and
// long lists blended concurrently with the others. The host does not wait before the frame is
// complete: stages read the numbers of Gaussians and pairs on the device. Every frame is captured
// as a CUDA graph, which updates the previous instance unless the topology has changed. The buffers
// have the capacities that earlier frames of the same number needed (FrameContext::number). A frame
// that exceeds a capacity is detected, and redrawn with larger buffers before its pixels are read.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <utility>

#include "raster/cuda/common/pixels.cuh"
#include "raster/cuda/common/stage_clock.cuh"
#include "raster/cuda/common/stream.cuh"
#include "raster/cuda/fast/stages.cuh"

namespace qs::cuda::fast {

/// A frame's work as a CUDA graph: one launch runs all its kernels without the host in between.
class Graph {
 public:
  /// The values that determine a frame's kernels and the dependencies between them.
  using Topology = std::array<int, 8>;

  Graph() = default;
  Graph& operator=(Graph&&) = delete;
  ~Graph() { release(); }

  /// Captures the work that `work` enqueues in `stream`, and in streams that wait for it and that
  /// it later waits for. Nothing runs yet. `work` must not allocate, and `topology` must determine
  /// which kernels it enqueues.
  template <class Work>
  void capture(cudaStream_t stream, const Topology& topology, const Work& work) {
    check(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), "capture");
    cudaGraph_t graph = nullptr;
    try {
      work();
    } catch (...) {
      cudaStreamEndCapture(stream, &graph);
      if (graph != nullptr) cudaGraphDestroy(graph);
      cudaGetLastError();
      throw;
    }
    check(cudaStreamEndCapture(stream, &graph), "capture");
    const Captured captured{graph};
    adopt(graph, topology);
    check(cudaGraphUpload(instance_, stream), "cudaGraphUpload");
  }

  void launch(cudaStream_t stream) { check(cudaGraphLaunch(instance_, stream), "frame"); }

 private:
  /// Is destroyed even if its instantiation throws, for example without memory.
  struct Captured {
    cudaGraph_t graph;
    ~Captured() { cudaGraphDestroy(graph); }
  };

  /// Updates the instance in place if only kernel functions and arguments changed.
  void adopt(cudaGraph_t graph, const Topology& topology) {
    if (instance_ != nullptr && topology == topology_) {
      cudaGraphExecUpdateResultInfo info;
      if (cudaGraphExecUpdate(instance_, graph, &info) == cudaSuccess) return;
      cudaGetLastError();
    }
    release();
    // Without this flag all kernels would run at the priority of the stream of launch().
    check(cudaGraphInstantiate(&instance_, graph, cudaGraphInstantiateFlagUseNodePriority),
          "cudaGraphInstantiate");
    topology_ = topology;
  }

  void release() {
    if (instance_ != nullptr) cudaGraphExecDestroy(std::exchange(instance_, nullptr));
  }

  cudaGraphExec_t instance_ = nullptr;
  Topology topology_{};
};

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

  /// Enqueues a frame of a scene in Order::space, which fills `pixels`. Throws Error and Cancelled.
  void enqueue(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
               StageClock& clock);

  /// Waits for the enqueued frame, and draws it again if it exceeded a capacity. The arguments must
  /// be the same as in enqueue(). Returns false if the slices of a macro-tile do not fit, because
  /// its samples were not representative. Throws Error and Cancelled.
  bool finish(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock);

  /// Fills statistics, pairs, used pairs and trace of the drawn frame, as requested.
  void collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
               Frame& result);

  /// Enqueues a pass that fills Pixels::depth of the drawn frame.
  void draw_depth(const FrameContext& frame, Pixels& pixels);

  /// The lists and the splats of the drawn frame.
  ListInput lists(const FrameContext& frame) const { return scratch_.lists(frame); }

 private:
  /// Frames of a number.
  struct View {
    Graph graph;
    FrameSize size;  ///< of the frame, or with the capacities for the next
  };

  static bool occludes(const FrameContext& frame, const Outputs& outputs);
  /// Enqueues the frame with the size of its view.
  void enqueue_again(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                     StageClock& clock);
  /// True if the frame of this size found the samples of long lists if it has any, and blended
  /// their segments. Sets the size for drawing it again, or for the next frame.
  bool fit_segments(FrameSize& size);
  /// Sets the counters of the frame from the counters of its slabs.
  void merge_counters(unsigned slabs);
  /// The number of slabs in which a view of so many blocks of Gaussians is drawn.
  unsigned slabs_of(std::uint32_t shown_blocks) const;
  void run(const FrameContext& frame, const Outputs& outputs, Pixels& pixels, StageClock& clock,
           cudaStream_t side_stream);
  /// Draws a slab, or a frame that has none.
  void run_slab(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                StageClock& clock, cudaStream_t side_stream, const OcclusionView& occlusion);
  void append_gaussians(const FrameContext& frame, Trace& trace) const;

  Stream side_stream_;  // low priority: its kernels yield to the main stream
  Stream full_stream_;  // for full macro-tiles
  Event footprints_known_, projected_, listed_, colored_, scheduled_, blended_;
  std::map<std::size_t, View> views_;  // by FrameContext::number
  PinnedValue<std::array<FastCounters, OcclusionView::kMostSlabs>> of_slabs_;
  FastCounters counters_{};  // the largest of all slabs; visible and entries: their sums
  std::uint64_t pairs_ = 0;  // of all slabs
  Scratch scratch_;
  DeviceBuffer<float> depths_;  // by place, for draw_depth()
  MacroSizePolicy macro_size_policy_;
  FrameSize last_size_;                    // with the capacities for frames of new numbers
  unsigned slabs_ = 1, forced_slabs_ = 0;  // of the previous frame with occlusion; if not 0
};

}  // namespace qs::cuda::fast
