// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/scene.h"

#include "raster/scene/spatial_order.h"

namespace qs::cpu::fast {
namespace {

BlockBounds bounds_of(const Block& block) {
  BlockBounds bounds;
  for (std::size_t lane = 0; lane < kBlock; ++lane) {
    bounds.include({block.x[lane], block.y[lane], block.z[lane]},
                   {block.xx[lane], block.xy[lane], block.xz[lane], block.yy[lane], block.yz[lane],
                    block.zz[lane]});
  }
  return bounds;
}

}  // namespace

SceneBlocks make_scene(const GaussianCloud& cloud, ThreadPool& pool) {
  const Array<std::uint32_t> order = spatial_order(cloud, pool);
  SceneBlocks scene{make_blocks(cloud, order, pool), {}, make_harmonics(cloud, order, pool)};
  scene.bounds.resize(scene.blocks.size());
  pool.for_chunks(scene.blocks.size(), 16, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t b = begin; b < end; ++b) scene.bounds[b] = bounds_of(scene.blocks[b]);
  });
  return scene;
}

}  // namespace qs::cpu::fast
