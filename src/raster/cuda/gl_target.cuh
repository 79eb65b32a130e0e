// SPDX-License-Identifier: MIT
//
// The way of a frame into a texture of OpenGL, as RGBA8, without leaving the GPU. All of CUDA-GL
// interop is here. Whenever a texture changes hands, the GPU switches between the contexts of CUDA
// and OpenGL, 0.2 to 0.9 ms on an H200, also in the middle of a frame. So the texture of the next
// frame is taken when this one was given back, pixels are written right behind the frame, and the
// texture is given back when the GPU is done with both.
#pragma once

#include <map>
#include <optional>

#include <cuda_runtime.h>

#include "raster/cuda/stream.cuh"
#include "raster/renderer.h"

struct cudaGraphicsResource;

namespace qs::cuda {

class GlTarget {
 public:
  explicit GlTarget(int device) : device_(device) {}
  ~GlTarget();
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;

  /// Takes the texture from OpenGL, beside what other streams do; one at a time, another one is
  /// given back. Throws Error(device) when OpenGL does not run on this GPU.
  void take(const GlTexture& texture);

  /// Rounds `color` (height x width x 3 on the device) to 8 bits and writes it to the texture that
  /// was taken, behind what is in the stream. Throws Error(device) when the texture has another
  /// size.
  void present(const float* color, int width, int height, cudaStream_t stream);

  /// Gives the texture back, if one is taken; the GPU must be done with it.
  void give_back() noexcept;

  /// Of the last present(), once the stream is done with it.
  float present_ms() const;

 private:
  cudaGraphicsResource* registered(const GlTexture& texture);

  struct Registration {
    unsigned version = 0;
    cudaGraphicsResource* resource = nullptr;
  };

  int device_;
  std::map<unsigned, Registration> registrations_;  // by the texture's name
  struct Taken {
    GlTexture texture;
    cudaGraphicsResource* resource = nullptr;  // null: none is taken
    cudaExtent size{};
    cudaSurfaceObject_t surface = 0;  // how kernels write to it
  } taken_;

  // Made with the first texture: most renderers present nothing.
  struct Clockwork {
    explicit Clockwork(int device);
    ~Clockwork();
    Stream stream;  // textures are taken in it
    Event ready;
    cudaEvent_t begin = nullptr, end = nullptr;
  };
  std::optional<Clockwork> clockwork_;
};

}  // namespace qs::cuda
