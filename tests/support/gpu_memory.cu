// SPDX-License-Identifier: MIT
#include "raster/cuda/common/check.cuh"
#include "support/gpu_memory.h"

namespace qs::test {

using cuda::check;

GpuMemory::GpuMemory(std::size_t bytes) : bytes_(bytes) {
  if (bytes > 0) check(cudaMalloc(&data_, bytes), "memory of a test");
}

GpuMemory::~GpuMemory() { cudaFree(data_); }

void GpuMemory::upload(const void* from) {
  if (bytes_ == 0) return;
  check(cudaMemcpyAsync(data_, from, bytes_, cudaMemcpyHostToDevice, nullptr), "upload");
  check(cudaStreamSynchronize(nullptr), "upload");
}

void GpuMemory::download(void* to) const {
  if (bytes_ == 0) return;
  check(cudaMemcpyAsync(to, data_, bytes_, cudaMemcpyDeviceToHost, nullptr), "download");
  check(cudaStreamSynchronize(nullptr), "download");
}

void GpuMemory::fill(int byte) {
  if (bytes_ == 0) return;
  check(cudaMemsetAsync(data_, byte, bytes_, nullptr), "fill");
  check(cudaStreamSynchronize(nullptr), "fill");
}

}  // namespace qs::test
