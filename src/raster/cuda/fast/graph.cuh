// SPDX-License-Identifier: MIT
//
// A frame's work as a CUDA graph: one launch runs all its kernels without the host in between.
#pragma once

#include <array>
#include <utility>

#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::fast {

class Graph {
 public:
  /// The values that determine a frame's kernels and the dependencies between them.
  using Topology = std::array<int, 7>;

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

}  // namespace qs::cuda::fast
