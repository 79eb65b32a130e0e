// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>

#include "raster/cuda/upload.cuh"
#include "raster/scene/activated_cloud.h"

namespace qs::cuda {
namespace {

constexpr std::size_t kChunk = 1 << 16;  // Gaussians per copy

__global__ void split_gaussians(const ActiveGaussian* chunk, unsigned count, float4* positions,
                                float4* covariances, float2* covariances_z) {
  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const ActiveGaussian& g = chunk[i];
  const Covariance3<float>& c = g.covariance;
  positions[i] = {g.position.x, g.position.y, g.position.z, g.log2_255_opacity};
  covariances[i] = {c.xx, c.xy, c.xz, c.yy};
  covariances_z[i] = {c.yz, c.zz};
}

/// Transposes: value k of row i of `chunk` becomes element `first + i` of array k. There are
/// `width` arrays of `array_size` values each.
__global__ void transpose_rows(const float* chunk, unsigned rows, unsigned width,
                               std::size_t array_size, std::size_t first, float* arrays) {
  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= rows) return;
  for (unsigned k = 0; k < width; ++k) {
    arrays[k * array_size + first + i] = chunk[std::size_t{i} * width + k];
  }
}

}  // namespace

void upload(const GaussianCloud& cloud, ThreadPool& pool, const Progress& progress,
            cudaStream_t stream, DeviceCloud& device) {
  device.count = 0;
  if (cloud.size() > std::numeric_limits<std::int32_t>::max()) {
    throw Error(ErrorKind::device, "cuda: the scene has " + std::to_string(cloud.size()) +
                                       " Gaussians, at most 2147483647 can be drawn");
  }
  const auto width = static_cast<unsigned>(3 * sh_coefficient_count(cloud.sh_degree));
  constexpr std::size_t kGeometryBytes = 10 * sizeof(float);
  require_memory("the scene", cloud.size() * (kGeometryBytes + width * sizeof(float)),
                 device.positions.bytes() + device.covariances.bytes() +
                     device.covariances_z.bytes() + device.sh.bytes());
  // The old scene is freed first, because both scenes together may not fit.
  device = {};
  device.positions.reserve("the scene", cloud.size());
  device.covariances.reserve("the scene", cloud.size());
  device.covariances_z.reserve("the scene", cloud.size());
  device.sh.reserve("the scene", cloud.size() * width);

  progress.update(0);
  const ActivatedCloud active = activate(cloud, pool);
  const std::size_t chunk_size = std::min(kChunk, cloud.size());
  DeviceBuffer<ActiveGaussian> gaussians;
  DeviceBuffer<float> rows;
  gaussians.reserve("the scene", chunk_size);
  rows.reserve("the scene", chunk_size * width);
  for (std::size_t first = 0; first < cloud.size(); first += kChunk) {
    progress.update(0.3f + 0.7f * static_cast<float>(first) / static_cast<float>(cloud.size()));
    const std::size_t count = std::min(kChunk, cloud.size() - first);
    const auto n = static_cast<unsigned>(count);
    check(cudaMemcpyAsync(gaussians.data(), active.gaussians.data() + first,
                          count * sizeof(ActiveGaussian), cudaMemcpyHostToDevice, stream),
          "upload");
    launch("split_gaussians", split_gaussians, blocks_for(count), stream, gaussians.data(), n,
           device.positions.data() + first, device.covariances.data() + first,
           device.covariances_z.data() + first);
    check(cudaMemcpyAsync(rows.data(), cloud.sh.data() + first * (width / 3),
                          count * width * sizeof(float), cudaMemcpyHostToDevice, stream),
          "upload");
    launch("transpose_rows", transpose_rows, blocks_for(count), stream, rows.data(), n, width,
           cloud.size(), first, device.sh.data());
  }
  check(cudaStreamSynchronize(stream), "upload");
  if (cloud.size() > 0) device.low = device.high = cloud.positions[0];
  for (const glm::vec3& position : cloud.positions) {
    device.low = glm::min(device.low, position);
    device.high = glm::max(device.high, position);
  }
  device.sh_degree = cloud.sh_degree;
  device.antialiased = cloud.antialiased;
  device.count = static_cast<std::uint32_t>(cloud.size());
  progress.update(1);
}

}  // namespace qs::cuda
