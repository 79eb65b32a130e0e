// SPDX-License-Identifier: MIT
//
// The way of a frame into a pixel buffer of OpenGL, as RGBA8, without leaving the GPU. All of
// CUDA-GL interop is here. Buffers are registered once per storage (GlBuffer::version).
#pragma once

#include <map>

#include <cuda_runtime.h>

#include "raster/renderer.h"

struct cudaGraphicsResource;

namespace qs::cuda {

class GlTarget {
 public:
  GlTarget() = default;
  ~GlTarget();
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;

  /// Rounds `color` (height x width x 3 on the device) to 8 bits and writes it to the buffer,
  /// behind what is in the stream. Throws Error(device) when OpenGL does not run on this GPU or the
  /// buffer is too small.
  void present(const float* color, int width, int height, const GlBuffer& buffer,
               cudaStream_t stream);

  /// Of the last present(), once the stream is done with it.
  float present_ms() const;

 private:
  cudaGraphicsResource* registered(const GlBuffer& buffer);

  struct Registration {
    unsigned version = 0;
    cudaGraphicsResource* resource = nullptr;
  };
  std::map<unsigned, Registration> registrations_;  // by the buffer's name
  cudaEvent_t begin_ = nullptr, end_ = nullptr;
};

}  // namespace qs::cuda
