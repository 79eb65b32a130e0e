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
      }
    }
  });
  return blocks;
}

Harmonics make_harmonics(const GaussianCloud& cloud, ThreadPool& pool) {
  Harmonics sh;
  sh.degree = cloud.sh_degree;
  const std::size_t per_gaussian = sh.group_size() / kGroup;
  const std::size_t groups = (cloud.size() + kBlock - 1) / kBlock * (kBlock / kGroup);
  sh.values.resize(groups * sh.group_size());
  pool.for_chunks(groups, 256, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t group = begin; group < end; ++group) {
      float* to = &sh.values[group * sh.group_size()];
      for (std::size_t lane = 0; lane < kGroup; ++lane) {
        const std::size_t i = group * kGroup + lane;
        const float* from = i < cloud.size() ? &cloud.sh.data()->x + i * per_gaussian : nullptr;
        for (std::size_t k = 0; k < per_gaussian; ++k)
          to[k * kGroup + lane] = from != nullptr ? from[k] : 0.0f;
      }
    }
  });
  return sh;
}

}  // namespace qs::cpu::fast
