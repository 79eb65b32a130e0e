// SPDX-License-Identifier: MIT
//
// The scene on the GPU, as a structure of arrays: threads of neighbouring Gaussians read
// neighbouring addresses.
#pragma once

#include "raster/base/parallel.h"
#include "raster/base/progress.h"
#include "raster/cuda/device_buffer.cuh"
#include "raster/kernel/footprint.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::cuda {

/// The pointers that kernels read. Passed by value.
struct CloudView {
  const float4* positions;      ///< x, y, z, log2(255 opacity)
  const float4* covariances;    ///< xx, xy, xz, yy
  const float2* covariances_z;  ///< yz, zz
  const float* sh;              ///< array 3 k + c, of `count` values: channel c of coefficient k
  std::uint32_t count;

  __device__ ActiveGaussian gaussian(std::uint32_t i) const {
    const float4 p = positions[i], a = covariances[i];
    const float2 b = covariances_z[i];
    return {{p.x, p.y, p.z}, {a.x, a.y, a.z, a.w, b.x, b.y}, p.w};
  }

  __device__ glm::vec3 coefficient(std::uint32_t i, int k) const {
    const float* red = sh + std::size_t{3} * k * count + i;
    return {red[0], red[count], red[std::size_t{2} * count]};
  }
};

struct DeviceCloud {
  DeviceBuffer<float4> positions, covariances;
  DeviceBuffer<float2> covariances_z;
  DeviceBuffer<float> sh;
  std::uint32_t count = 0;
  int sh_degree = 0;
  bool antialiased = false;
  glm::vec3 low{0.0f}, high{0.0f};  ///< corners of the bounding box of all positions

  CloudView view() const {
    return {positions.data(), covariances.data(), covariances_z.data(), sh.data(), count};
  }
};

/// Replaces the scene in `device`. Throws Error(device) and Cancelled; `device` is then empty.
void upload(const GaussianCloud& cloud, ThreadPool& pool, const Progress& progress,
            cudaStream_t stream, DeviceCloud& device);

}  // namespace qs::cuda
