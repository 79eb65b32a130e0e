// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/scene.h"

#include "raster/cpu/fast/spatial_order.h"

namespace qs::cpu::fast {

Scene make_scene(const GaussianCloud& cloud, ThreadPool& pool) {
  const Array<std::uint32_t> order = spatial_order(cloud, pool);
  Scene scene{make_blocks(cloud, order, pool), {}, make_harmonics(cloud, order, pool)};
  scene.bounds.resize(scene.blocks.size());
  pool.for_chunks(scene.blocks.size(), 16, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t b = begin; b < end; ++b) scene.bounds[b] = bounds_of(scene.blocks[b]);
  });
  return scene;
}

}  // namespace qs::cpu::fast
