// SPDX-License-Identifier: MIT
//
// A frame's work as a CUDA graph: launched as one, its kernels follow each other without the host.
#pragma once

#include <array>
#include <utility>

#include "raster/cuda/stream.cuh"

namespace qs::cuda::fast {

class Graph {
 public:
  /// What decides how many kernels a frame has and which waits for which.
  using Shape = std::array<int, 5>;

  Graph() = default;
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;
  ~Graph() { release(); }

  /// Captures what `work` puts into `stream` (and into streams that wait for it, and for which it
  /// waits again). Nothing runs yet. `work` must not allocate, and must do work of this shape.
  template <class Work>
  void capture(cudaStream_t stream, const Shape& shape, const Work& work) {
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
    adopt(graph, shape);
    cudaGraphDestroy(graph);
    check(cudaGraphUpload(instance_, stream), "cudaGraphUpload");
  }

  void launch(cudaStream_t stream) { check(cudaGraphLaunch(instance_, stream), "frame"); }

 private:
  /// An instance takes other kernels and arguments, but no other shape.
  void adopt(cudaGraph_t graph, const Shape& shape) {
    if (instance_ != nullptr && shape == shape_) {
      cudaGraphExecUpdateResultInfo info;
      if (cudaGraphExecUpdate(instance_, graph, &info) == cudaSuccess) return;
      cudaGetLastError();
    }
    release();
    check(cudaGraphInstantiate(&instance_, graph), "cudaGraphInstantiate");
    shape_ = shape;
  }

  void release() {
    if (instance_ != nullptr) cudaGraphExecDestroy(std::exchange(instance_, nullptr));
  }

  cudaGraphExec_t instance_ = nullptr;
  Shape shape_{};
};

}  // namespace qs::cuda::fast
