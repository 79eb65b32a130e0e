// SPDX-License-Identifier: MIT
//
// A frame's work as a CUDA graph: launched as one, its kernels follow each other without the host.
#pragma once

#include <utility>

#include "raster/cuda/stream.cuh"

namespace qs::cuda::fast {

class Graph {
 public:
  Graph() = default;
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;
  ~Graph() { release(); }

  /// Captures what `work` puts into `stream` (and into streams that wait for it, and for which it
  /// waits again). Nothing runs yet. `work` must not allocate.
  template <class Work>
  void capture(cudaStream_t stream, const Work& work) {
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
    adopt(graph);
    cudaGraphDestroy(graph);
  }

  void launch(cudaStream_t stream) { check(cudaGraphLaunch(instance_, stream), "frame"); }

 private:
  /// Kernels and arguments may differ from the instance's, the order in which they run may not.
  void adopt(cudaGraph_t graph) {
    cudaGraphExecUpdateResultInfo info;
    if (instance_ != nullptr) {
      if (cudaGraphExecUpdate(instance_, graph, &info) == cudaSuccess) return;
      cudaGetLastError();
      release();
    }
    check(cudaGraphInstantiate(&instance_, graph), "cudaGraphInstantiate");
  }

  void release() {
    if (instance_ != nullptr) cudaGraphExecDestroy(std::exchange(instance_, nullptr));
  }

  cudaGraphExec_t instance_ = nullptr;
};

}  // namespace qs::cuda::fast
