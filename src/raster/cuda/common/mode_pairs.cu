// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/common/mode_pairs.cuh"
#include "raster/cuda/common/warp.cuh"

namespace qs::cuda {
namespace {

/// A thread per Gaussian. A block adds its sums once per mode; integers make the order irrelevant.
__global__ void __launch_bounds__(kThreads)
    count_mode_pairs(CloudView cloud, View<float> view, FootprintRules rules, TileGrid grid,
                     Frustum frustum, ModeCounts* counts) {
  static_assert(kThreads == kBlockGaussians);
  __shared__ bool is_missed;
  if (cloud.bounds != nullptr) {
    if (threadIdx.x == 0)
      is_missed = !cloud.draws_block(blockIdx.x) || frustum.misses(cloud.bounds[blockIdx.x]);
    __syncthreads();
    if (is_missed) return;
  }
  const std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  TilesOfModes own{};
  Projected projected;
  if (i < cloud.count && cloud.draws(i) && project(view, rules, cloud.gaussian(i), projected))
    own = tiles_of_modes(projected.footprint, grid);
#pragma unroll
  for (int mode = 0; mode < kCullerCount; ++mode) {
    const auto tiles = static_cast<unsigned long long>(own.tiles[mode]);
    const auto pairs = sum_of_block<kThreads>(tiles).total;
    const int visible = __syncthreads_count(tiles > 0);
    if (threadIdx.x == 0 && visible > 0) {
      atomicAdd(&counts->tile_pairs[mode], pairs);
      atomicAdd(&counts->visible[mode], static_cast<unsigned>(visible));
    }
  }
}

}  // namespace

void ModeCounter::enqueue(const DeviceCloud& cloud, const CountedView& counted,
                          cudaStream_t stream) {
  counts_.reserve("the counts of the modes", 1);
  if (!on_host_) on_host_.emplace();
  set_zero("count", counts_.data(), 1, stream);
  const RenderSettings& settings = counted.settings;
  FootprintRules rules =
      footprint_rules(settings, settings.antialiased.value_or(cloud.antialiased));
  rules.keep_faint = true;  // tiles_of_modes() drops faint Gaussians mode by mode
  const TileGrid grid = TileGrid::of_image(counted.camera.width, counted.camera.height);
  const View<float> view = make_view<float>(counted.camera);
  launch("count", count_mode_pairs, std::max(blocks_for(cloud.count), 1u), stream, cloud.view(),
         view, rules, grid, Frustum(view, rules, grid), counts_.data());
  check(cudaMemcpyAsync(&**on_host_, counts_.data(), sizeof(ModeCounts), cudaMemcpyDeviceToHost,
                        stream),
        "count");
}

std::vector<ModePairs> ModeCounter::result() const {
  std::vector<ModePairs> pairs;
  for (int mode = 0; mode < kCullerCount; ++mode)
    pairs.push_back({(*on_host_)->tile_pairs[mode], (*on_host_)->visible[mode]});
  return pairs;
}

}  // namespace qs::cuda
