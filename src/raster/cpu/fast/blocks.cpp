// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/blocks.h"

#include <cmath>

namespace qs::cpu::fast {

Array<Block> make_blocks(const ActivatedCloud& active, ThreadPool& pool) {
  const std::size_t size = active.gaussians.size();
  Array<Block> blocks((size + kBlock - 1) / kBlock);
  pool.for_chunks(blocks.size(), 16, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t b = begin; b < end; ++b) {
      Block& block = blocks[b];
      for (std::size_t lane = 0; lane < kBlock; ++lane) {
        const std::size_t i = b * kBlock + lane;
        const ActiveGaussian nobody{glm::vec3(NAN), {}, 0};
        const ActiveGaussian& g = i < size ? active.gaussians[i] : nobody;
        block.x[lane] = g.position.x;
        block.y[lane] = g.position.y;
        block.z[lane] = g.position.z;
        block.xx[lane] = g.covariance.xx;
        block.xy[lane] = g.covariance.xy;
        block.xz[lane] = g.covariance.xz;
        block.yy[lane] = g.covariance.yy;
        block.yz[lane] = g.covariance.yz;
        block.zz[lane] = g.covariance.zz;
        block.log2_255_opacity[lane] = g.log2_255_opacity;
        block.opacity[lane] = i < size ? active.opacities[i] : 0.0f;
      }
    }
  });
  return blocks;
}

}  // namespace qs::cpu::fast
