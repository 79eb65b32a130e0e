// SPDX-License-Identifier: MIT
//
// The scene on the GPU, as a structure of arrays: threads of neighbouring Gaussians read
// neighbouring addresses. A place is an index into these arrays.
#pragma once

#include <span>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "raster/cuda/common/device_buffer.cuh"
#include "raster/kernel/frustum.h"
#include "raster/kernel/half.h"
#include "raster/scene/gaussian_cloud.h"
#include "raster/scene/gaussian_set.h"

namespace qs::cuda {

/// The order of the Gaussians on the GPU: as in the file, or as spatial_order() has them.
enum class Order { file, space };

/// Number of Gaussians with common bounds in Order::space: one block of threads.
inline constexpr unsigned kBlockGaussians = kThreads;

/// The pointers that kernels read. Passed by value.
struct CloudView {
  const float4* positions;      ///< x, y, z, log2(255 opacity)
  const float4* covariances;    ///< xx, xy, xz, yy
  const float2* covariances_z;  ///< yz, zz
  const float* sh;              ///< array 3 k + c, of `count` values: channel c of coefficient k
  std::uint32_t count;
  // In the order in space only:
  const std::uint32_t* file_indices;  ///< index in the file, which decides ties of depth
  const BlockBounds* bounds;          ///< per kBlockGaussians
  /// Coefficients of degree >= 1 as halves, if halves equal all coefficients of the scene, as in
  /// scenes from .spz files; `sh` then has only the coefficient of degree 0. Otherwise null.
  const std::uint16_t* sh_halves;
  /// A bit per place, in words of 32, see Renderer::set_drawn(); null: all. Whole blocks of words.
  const std::uint32_t* drawn;

  __device__ bool draws(std::uint32_t i) const {
    return drawn == nullptr || (drawn[i / 32] >> i % 32 & 1) != 0;
  }
  /// False if no Gaussian of the block is drawn.
  __device__ bool draws_block(std::uint32_t block) const {
    if (drawn == nullptr) return true;
    const uint4* const words = reinterpret_cast<const uint4*>(drawn) + std::size_t{2} * block;
    const uint4 a = words[0], b = words[1];
    return (a.x | a.y | a.z | a.w | b.x | b.y | b.z | b.w) != 0;
  }

  __device__ ActiveGaussian gaussian(std::uint32_t i) const {
    const float4 p = positions[i], a = covariances[i];
    const float2 b = covariances_z[i];
    return {{p.x, p.y, p.z}, {a.x, a.y, a.z, a.w, b.x, b.y}, p.w};
  }

  __device__ glm::vec3 coefficient(std::uint32_t i, int k) const {
    const float* red = sh + std::size_t{3} * k * count + i;
    return {red[0], red[count], red[std::size_t{2} * count]};
  }

  /// The same if the scene has halves.
  __device__ glm::vec3 coefficient_of_halves(std::uint32_t i, int k) const {
    if (k == 0) return coefficient(i, 0);
    const std::uint16_t* red = sh_halves + std::size_t{3} * (k - 1) * count + i;
    return {float_of_half(red[0]), float_of_half(red[count]),
            float_of_half(red[std::size_t{2} * count])};
  }
};

/// Memory that uploads of the same scene reuse.
struct UploadScratch {
  DeviceBuffer<ActiveGaussian> gaussians;
  DeviceBuffer<float> rows;
  DeviceBuffer<std::uint32_t> inexact, places, set;
};

struct DeviceCloud {
  DeviceBuffer<float4> positions, covariances;
  DeviceBuffer<float2> covariances_z;
  DeviceBuffer<float> sh;
  DeviceBuffer<std::uint32_t> file_indices;  ///< see CloudView
  DeviceBuffer<BlockBounds> bounds;
  DeviceBuffer<std::uint16_t> sh_halves;  ///< empty: `sh` has all coefficients
  DeviceBuffer<std::uint32_t> drawn;      ///< see CloudView; not used if draws_all
  bool draws_all = true;
  // On the host, made by the first update() in the order in space:
  std::vector<std::uint32_t> places;     ///< by index in the file
  std::vector<BlockBounds> host_bounds;  ///< of the blocks, with all Gaussians that were in them
  UploadScratch scratch;
  std::uint32_t count = 0;
  int sh_degree = 0;
  bool antialiased = false;

  std::uint64_t bytes() const {
    return positions.bytes() + covariances.bytes() + covariances_z.bytes() + sh.bytes() +
           file_indices.bytes() + bounds.bytes() + sh_halves.bytes() + drawn.bytes();
  }

  CloudView view() const {
    const std::uint32_t* const bits = draws_all ? nullptr : drawn.data();
    return {positions.data(),    covariances.data(), covariances_z.data(), sh.data(), count,
            file_indices.data(), bounds.data(),      sh_halves.data(),     bits};
  }
};

/// Memory of an uploaded scene, if it has no halves.
std::uint64_t scene_bytes(const GaussianCloud& cloud, Order order);

/// Replaces the scene in `device`. Throws Error(device) and Cancelled; `device` is then empty.
void upload(const GaussianCloud& cloud, Order order, ThreadPool& pool, const Progress& progress,
            cudaStream_t stream, DeviceCloud& device);

/// Makes what update() keeps on the host, which it makes itself otherwise. Throws Error(device).
void expect_updates(cudaStream_t stream, DeviceCloud& device);

/// Uploads Gaussians of `cloud` again, whose scene is in `device`. False if their coefficients need
/// floats in place of halves; then the scene must be uploaded again. Throws Error(device).
bool update(const GaussianCloud& cloud, std::span<const std::uint32_t> changed, ThreadPool& pool,
            cudaStream_t stream, DeviceCloud& device);

/// Sets CloudView::drawn to a set of the scene's Gaussians; of size 0: all. Throws Error(device).
void set_drawn(const GaussianSet& set, cudaStream_t stream, DeviceCloud& device);

}  // namespace qs::cuda
