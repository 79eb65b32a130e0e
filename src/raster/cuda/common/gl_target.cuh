// SPDX-License-Identifier: MIT
//
// Copies a finished frame into an OpenGL texture (RGBA8) through CUDA-GL interop, without leaving
// the GPU. Mapping and unmapping a texture makes the GPU switch contexts, which takes 0.2 to 0.9 ms
// on an H200. So the next texture can be mapped one frame ahead, the copy is enqueued right after
// the frame, and the texture is unmapped once the GPU has finished both.
#pragma once

#include <map>
#include <optional>

#include <cuda_runtime.h>

#include "raster/api/renderer.h"
#include "raster/cuda/common/stream.cuh"

struct cudaGraphicsResource;

namespace qs::cuda {

class GlTarget {
 public:
  explicit GlTarget(int device) : device_(device) {}
  ~GlTarget();
  GlTarget& operator=(GlTarget&&) = delete;

  /// Maps the texture for CUDA, concurrently with the work of other streams. Unmaps the texture
  /// mapped before, if it is a different texture. Throws Error(device) if OpenGL runs on another
  /// GPU.
  void map(const GlTexture& texture);

  /// Enqueues in `stream` the copy of `color` (height x width x 3 on the device, rounded to 8 bits)
  /// to the mapped texture. Throws Error(device) if the texture has another size.
  void present(const float* color, int width, int height, cudaStream_t stream);

  /// Unmaps the mapped texture, if any. The GPU must have finished using it.
  void unmap() noexcept;

  /// GPU time of the last present(), which must have finished.
  float present_ms() const;

 private:
  cudaGraphicsResource* registered(const GlTexture& texture);

  struct Registration {
    unsigned version = 0;
    cudaGraphicsResource* resource = nullptr;
  };

  int device_;
  std::map<unsigned, Registration> registrations_;  // by the texture's name
  struct Mapping {
    GlTexture texture;
    cudaGraphicsResource* resource = nullptr;  // null: no texture is mapped
    cudaExtent size{};
    cudaSurfaceObject_t surface = 0;  // the surface that kernels write to
  } mapping_;

  struct InteropStream {
    explicit InteropStream(int device) : stream(device, true) {}
    Stream stream;  // in which textures are mapped and unmapped
    Event mapped;
    TimedEvent begin, end;  // of present()
  };
  std::optional<InteropStream> interop_;  // created lazily: most renderers never present to OpenGL
};

}  // namespace qs::cuda
