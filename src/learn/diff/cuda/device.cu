// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/device.h"
#include "learn/diff/cuda/frame_blocks.cuh"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::diff {
namespace {

__device__ void store(float value, float& to) { to = value; }
/// As to_8bit() of image.h.
__device__ void store(float value, std::uint8_t& to) {
  to = static_cast<std::uint8_t>(255.0f * fminf(fmaxf(0.0f, value), 1.0f) + 0.5f);
}

template <class T>
void store_values(const PackedMap& map, const Pixels<T>& to, const Queue& queue) {
  const auto channels = static_cast<std::size_t>(map.channels);
  const auto width = static_cast<std::size_t>(map.width);
  for_each_item("pictures", static_cast<std::size_t>(map.height) * width * channels,
                stream_of(queue), [=] __device__(std::size_t i) {
                  const std::size_t pixel = i / channels;
                  store(map.values[i],
                        to.at(static_cast<int>(pixel % width), static_cast<int>(pixel / width),
                              static_cast<int>(i % channels)));
                });
}

}  // namespace

SelectedGpu::SelectedGpu(int device) {
  check(cudaGetDevice(&before_), "cudaGetDevice");
  check(cudaSetDevice(device), "cudaSetDevice");  // a new thread has no context before
  is_other_ = before_ != device;
}

SelectedGpu::~SelectedGpu() {
  if (is_other_) cudaSetDevice(before_);
}

bool is_gpu_memory(const void* memory) {
  cudaPointerAttributes attributes{};
  const bool known = cudaPointerGetAttributes(&attributes, memory) == cudaSuccess;
  cudaGetLastError();  // clears the error of an unknown pointer
  return known && attributes.devicePointer != nullptr;
}

std::optional<int> other_gpu_of(const void* memory, int device) {
  static const int devices = [] {  // constant in a process
    int count = 0;
    return cudaGetDeviceCount(&count) == cudaSuccess ? count : 0;
  }();
  if (devices == 1 && device == 0) return std::nullopt;
  cudaPointerAttributes found{};
  const bool known = device < devices && cudaPointerGetAttributes(&found, memory) == cudaSuccess;
  cudaGetLastError();  // clears the error of an unknown pointer
  if (!known || found.type != cudaMemoryTypeDevice || found.device == device) return std::nullopt;
  return found.device;
}

void* allocate(std::size_t bytes, const Queue& queue) {
  void* memory = nullptr;
  check(cudaMallocAsync(&memory, bytes, stream_of(queue)), "temporary memory");
  return memory;
}

void free(void* memory, const Queue& queue) noexcept { cudaFreeAsync(memory, stream_of(queue)); }

void copy_to_gpu(void* to, const void* from, std::size_t bytes, const Queue& queue) {
  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream_of(queue)),
        "copy to the GPU");
}

void copy_from_gpu(void* to, const void* from, std::size_t bytes, const Queue& queue) {
  copy_to_host(static_cast<const std::byte*>(from), static_cast<std::byte*>(to), bytes,
               stream_of(queue));
}

void wait(const Queue& queue) { check(cudaStreamSynchronize(stream_of(queue)), "the stream"); }

void copy_on_gpu(void* to, const void* from, std::size_t bytes, const Queue& queue) {
  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, stream_of(queue)),
        "copy on the GPU");
}

void store_map(const PackedMap& map, const Pixels<float>& to, const Queue& queue) {
  store_values(map, to, queue);
}

void store_map(const PackedMap& map, const Pixels<std::uint8_t>& to, const Queue& queue) {
  store_values(map, to, queue);
}

}  // namespace qs::cuda::diff
