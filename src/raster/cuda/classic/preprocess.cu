// SPDX-License-Identifier: MIT
#include <glm/geometric.hpp>

#include "raster/cuda/classic/classic.cuh"
#include "raster/kernel/cull/modes.h"
#include "raster/kernel/sh.h"

namespace qs::cuda::classic {
namespace {

template <class P>
__global__ void __launch_bounds__(kThreads)
    preprocess_gaussians(CloudView cloud, View<float> view, FootprintRules rules, int sh_degree,
                         TileGrid grid, ClassicVisibleView out) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  std::uint32_t tiles = 0;
  ActiveGaussian gaussian;
  Projected projected;
  if (i < cloud.count && cloud.draws(i)) {
    gaussian = cloud.gaussian(i);
    if (project(view, rules, gaussian, projected))
      tiles = count_tiles<P>(projected.footprint, grid);
  }
  if (i <= cloud.count) out.tile_counts[i] = tiles;
  const int visible = __syncthreads_count(tiles > 0);
  if (threadIdx.x == 0 && visible > 0) atomicAdd(&out.counters->visible, visible);
  if (tiles == 0) return;

  out.depths[i] = projected.depth;
  out.footprints.store(i, projected.footprint);
  const glm::vec3 direction = glm::normalize(gaussian.position - view.position);
  const glm::vec3 color =
      sh_color<float>(sh_degree, direction, [&](int k) { return cloud.coefficient(i, k); });
  out.splats[i] = LogSplat::of(projected.footprint, color);
}

}  // namespace

void preprocess(const FrameContext& frame, ClassicVisible& visible) {
  constexpr const char* kWhat = "the frame's Gaussians";
  const std::size_t gaussians = frame.cloud.count;
  visible.tile_counts.reserve(kWhat, gaussians + 1);
  visible.depths.reserve(kWhat, gaussians);
  visible.footprints.reserve(kWhat, gaussians);
  visible.splats.reserve(kWhat, gaussians);
  visible.counters.reserve("the frame's counters", 1);
  set_zero("preprocess", visible.counters.data(), 1, frame.stream);
  with_culler(frame.settings.mode, [&]<class P>(P) {
    launch("preprocess", preprocess_gaussians<P>, blocks_for(std::uint64_t{frame.cloud.count} + 1),
           frame.stream, frame.cloud.view(), make_view<float>(frame.camera), frame.rules(),
           frame.sh_degree(), frame.grid, visible.view());
  });
}

}  // namespace qs::cuda::classic
