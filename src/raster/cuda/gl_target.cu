// SPDX-License-Identifier: MIT
#include <cuda_gl_interop.h>

#include "raster/cuda/check.cuh"
#include "raster/cuda/gl_target.cuh"

namespace qs::cuda {
namespace {

/// to_8bit() of image.h.
__device__ unsigned char rounded(float value) {
  return static_cast<unsigned char>(floorf(255.0f * fminf(fmaxf(0.0f, value), 1.0f) + 0.5f));
}

__global__ void __launch_bounds__(kThreads)
    to_rgba8(const float* color, uchar4* rgba, std::uint32_t pixels) {
  const std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  if (i >= pixels) return;
  rgba[i] =
      make_uchar4(rounded(color[3 * i]), rounded(color[3 * i + 1]), rounded(color[3 * i + 2]), 255);
}

}  // namespace

GlTarget::~GlTarget() {
  // Without a GL context (it went first) the driver has dropped the registrations already.
  for (auto& [name, registration] : registrations_)
    cudaGraphicsUnregisterResource(registration.resource);
  cudaGetLastError();
  if (begin_ != nullptr) cudaEventDestroy(begin_);
  if (end_ != nullptr) cudaEventDestroy(end_);
}

cudaGraphicsResource* GlTarget::registered(const GlBuffer& buffer) {
  Registration& registration = registrations_[buffer.name];
  if (registration.resource != nullptr && registration.version == buffer.version)
    return registration.resource;
  if (registration.resource != nullptr) {
    cudaGraphicsUnregisterResource(registration.resource);
    cudaGetLastError();
    registration.resource = nullptr;
  }
  check(cudaGraphicsGLRegisterBuffer(&registration.resource, buffer.name,
                                     cudaGraphicsRegisterFlagsWriteDiscard),
        "CUDA-GL interop");
  registration.version = buffer.version;
  return registration.resource;
}

void GlTarget::present(const float* color, int width, int height, const GlBuffer& buffer,
                       cudaStream_t stream) {
  if (begin_ == nullptr) {
    check(cudaEventCreate(&begin_), "cudaEventCreate");
    check(cudaEventCreate(&end_), "cudaEventCreate");
  }
  cudaGraphicsResource* resource = registered(buffer);
  check(cudaEventRecord(begin_, stream), "present");
  check(cudaGraphicsMapResources(1, &resource, stream), "CUDA-GL interop");
  void* mapped = nullptr;
  std::size_t bytes = 0;
  check(cudaGraphicsResourceGetMappedPointer(&mapped, &bytes, resource), "CUDA-GL interop");
  const auto pixels = static_cast<std::uint32_t>(width) * static_cast<std::uint32_t>(height);
  const bool fits = bytes >= 4 * static_cast<std::size_t>(pixels);
  if (fits) {
    launch("present", to_rgba8, (pixels + kThreads - 1) / kThreads, stream, color,
           static_cast<uchar4*>(mapped), pixels);
  }
  check(cudaGraphicsUnmapResources(1, &resource, stream), "CUDA-GL interop");
  check(cudaEventRecord(end_, stream), "present");
  if (!fits) throw Error(ErrorKind::device, "cuda: the GL buffer is smaller than the frame");
}

float GlTarget::present_ms() const {
  float ms = 0;
  check(cudaEventElapsedTime(&ms, begin_, end_), "present");
  return ms;
}

}  // namespace qs::cuda
