// SPDX-License-Identifier: MIT
#include <utility>

#include <cuda_gl_interop.h>

#include "raster/cuda/common/check.cuh"
#include "raster/cuda/common/gl_target.cuh"

namespace qs::cuda {
namespace {

/// Equals to_8bit() of image.h.
__device__ unsigned char rounded(float value) {
  return static_cast<unsigned char>(floorf(255.0f * fminf(fmaxf(0.0f, value), 1.0f) + 0.5f));
}

}  // namespace

GlTarget::~GlTarget() {
  unmap();
  // If the GL context was destroyed first, the driver has already dropped the registrations.
  for (auto& [name, registration] : registrations_)
    cudaGraphicsUnregisterResource(registration.resource);
  cudaGetLastError();
}

cudaGraphicsResource* GlTarget::registered(const GlTexture& texture) {
  Registration& registration = registrations_[texture.name];
  if (registration.resource != nullptr && registration.version == texture.version)
    return registration.resource;
  if (registration.resource != nullptr) {
    cudaGraphicsUnregisterResource(registration.resource);
    cudaGetLastError();
    registration.resource = nullptr;
  }
  check(cudaGraphicsGLRegisterImage(&registration.resource, texture.name, GL_TEXTURE_2D,
                                    cudaGraphicsRegisterFlagsSurfaceLoadStore),
        "CUDA-GL interop");
  registration.version = texture.version;
  return registration.resource;
}

void GlTarget::map(const GlTexture& texture) {
  if (mapping_.resource != nullptr && mapping_.texture == texture) return;
  unmap();
  if (!interop_) interop_.emplace(device_);
  cudaGraphicsResource* resource = registered(texture);
  check(cudaGraphicsMapResources(1, &resource, interop_->stream), "CUDA-GL interop");
  mapping_ = {texture, resource, {}, 0};
  try {
    cudaResourceDesc pixels{};
    pixels.resType = cudaResourceTypeArray;
    check(cudaGraphicsSubResourceGetMappedArray(&pixels.res.array.array, resource, 0, 0),
          "CUDA-GL interop");
    check(cudaArrayGetInfo(nullptr, &mapping_.size, nullptr, pixels.res.array.array),
          "CUDA-GL interop");
    check(cudaCreateSurfaceObject(&mapping_.surface, &pixels), "CUDA-GL interop");
    interop_->mapped.record(interop_->stream);
  } catch (...) {
    unmap();
    throw;
  }
}

void GlTarget::present(const float* color, int width, int height, cudaStream_t stream) {
  const auto columns = static_cast<std::uint32_t>(width), rows = static_cast<std::uint32_t>(height);
  if (mapping_.size.width != columns || mapping_.size.height != rows)
    throw Error(ErrorKind::device, "cuda: the GL texture has another size than the frame");
  interop_->begin.record(stream, "present");
  interop_->mapped.make_wait(stream);
  for_each_item("present", columns * rows, stream,
                [=, surface = mapping_.surface] __device__(std::uint32_t i) {
                  const uchar4 rgba = make_uchar4(rounded(color[3 * i]), rounded(color[3 * i + 1]),
                                                  rounded(color[3 * i + 2]), 255);
                  surf2Dwrite(rgba, surface, static_cast<int>(i % columns * sizeof rgba),
                              static_cast<int>(i / columns));
                });
  interop_->end.record(stream, "present");
}

void GlTarget::unmap() noexcept {
  if (mapping_.resource == nullptr) return;
  Mapping mapping = std::exchange(mapping_, {});
  cudaDestroySurfaceObject(mapping.surface);
  cudaGraphicsUnmapResources(1, &mapping.resource, interop_->stream);
  cudaGetLastError();
}

float GlTarget::present_ms() const { return interop_->end.ms_since(interop_->begin, "present"); }

}  // namespace qs::cuda
