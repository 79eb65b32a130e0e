// SPDX-License-Identifier: MIT
#include <atomic>
#include <cmath>

#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/half.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"

namespace qs::cpu::fast {

namespace {

/// Prefetch distance in Gaussians. Neighbours in a block are scattered in the cloud.
constexpr std::size_t kPrefetchedBlocks = 16;

/// Values of degree >= 1 in a group, at most.
constexpr std::size_t kMostRest = 3 * (sh_coefficient_count(kMaxShDegree) - 1) * kGroup;

/// Stores values 3 .. 3 + count - 1 of a group's members as [value][member].
void interleave(const float* const* members, std::size_t count, float* to) {
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t lane = 0; lane < kGroup; ++lane) *to++ = members[lane][3 + k];
}

void prefetch(const GaussianCloud& cloud, std::size_t i) {
  __builtin_prefetch(&cloud.positions[i]);
  __builtin_prefetch(&cloud.log_scales[i]);
  __builtin_prefetch(&cloud.rotations[i]);
  __builtin_prefetch(&cloud.opacity_logits[i]);
}

void put(const ActiveGaussian& g, Block& block, std::size_t lane) {
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

/// `order`: the cloud's indices in the order of the blocks.
Array<Block> make_blocks(const GaussianCloud& cloud, std::span<const std::uint32_t> order,
                         ThreadPool& pool) {
  Array<Block> blocks((order.size() + kBlock - 1) / kBlock);
  pool.for_each(blocks.size(), 16, [&](std::size_t b) {
    Block& block = blocks[b];
    for (std::size_t lane = 0; lane < kBlock; ++lane) {
      const std::size_t i = b * kBlock + lane;
      const ActiveGaussian padding{glm::vec3(NAN), {}, 0};
      if (i + kPrefetchedBlocks < order.size()) prefetch(cloud, order[i + kPrefetchedBlocks]);
      put(i < order.size() ? activate(cloud, order[i]).gaussian : padding, block, lane);
      block.gaussian[lane] = i < order.size() ? order[i] : 0;
    }
  });
  return blocks;
}

void include(BlockBounds& bounds, const Block& block, std::size_t lane) {
  bounds.include({block.x[lane], block.y[lane], block.z[lane]},
                 {block.xx[lane], block.xy[lane], block.xz[lane], block.yy[lane], block.yz[lane],
                  block.zz[lane]});
}

BlockBounds bounds_of(const Block& block) {
  BlockBounds bounds;
  for (std::size_t lane = 0; lane < kBlock; ++lane) include(bounds, block, lane);
  return bounds;
}

}  // namespace

Harmonics make_harmonics(const GaussianCloud& cloud, std::span<const std::uint32_t> order,
                         ThreadPool& pool) {
  Harmonics sh;
  sh.degree = cloud.sh_degree;
  const std::size_t groups = (cloud.size() + kBlock - 1) / kBlock * (kBlock / kGroup);
  const std::size_t rest = sh.rest_size() / kGroup, stride = 3 + rest;

  // Calls store(group, values of each member) for all groups. Members after the last Gaussian are
  // 0.
  const std::vector<float> padding(stride, 0.0f);
  const auto for_each_group = [&](const auto& store) {
    pool.for_each(groups, 256, [&](std::size_t group) {
      const auto member = [&](std::size_t i) {
        return i < order.size() ? &cloud.sh.data()->x + order[i] * stride : padding.data();
      };
      const float* members[kGroup];
      for (std::size_t lane = 0; lane < kGroup; ++lane) {
        members[lane] = member(group * kGroup + lane);
        const float* soon = member((group + 1) * kGroup + lane);
        for (std::size_t k = 0; k < stride; k += 16) __builtin_prefetch(soon + k);
      }
      store(group, members);
    });
  };

  std::atomic<bool> exact = true;
  sh.base.resize(groups * kGroup * 3);
  sh.halves.resize(groups * sh.rest_size());
  for_each_group([&](std::size_t group, const float* const* members) {
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t lane = 0; lane < kGroup; ++lane)
        sh.base[(group * 3 + k) * kGroup + lane] = members[lane][k];
    if (!exact) return;
    float values[kMostRest];
    interleave(members, rest, values);
    if (!to_halves(values, rest * kGroup, sh.halves.data() + group * rest * kGroup)) exact = false;
  });
  if (exact) return sh;
  sh.halves = {};
  sh.rest.resize(groups * sh.rest_size());
  for_each_group([&](std::size_t group, const float* const* members) {
    interleave(members, rest, sh.rest.data() + group * rest * kGroup);
  });
  return sh;
}

void SceneBlocks::set_drawn(const GaussianSet& set, ThreadPool& pool) {
  if (set.size() == 0) return drawn.clear();
  drawn.resize(blocks.size() * kDrawnWords);
  pool.for_each(drawn.size(), 64, [&](std::size_t word) {
    const std::uint32_t* const gaussians =
        blocks[word / kDrawnWords].gaussian + word % kDrawnWords * 64;
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < 64; ++i) bits |= std::uint64_t{set[gaussians[i]]} << i;
    drawn[word] = bits;
  });
}

bool SceneBlocks::update(const GaussianCloud& cloud, std::span<const std::uint32_t> changed,
                         ThreadPool& pool) {
  if (places.empty()) {
    places.resize(cloud.size());
    pool.for_each(cloud.size(), 4096, [&](std::size_t place) {
      places[blocks[place / kBlock].gaussian[place % kBlock]] = static_cast<std::uint32_t>(place);
    });
  }
  const std::size_t rest = harmonics.rest_size() / kGroup;
  std::atomic<bool> exact = true;
  pool.for_each(changed.size(), 256, [&](std::size_t k) {
    const std::size_t i = changed[k], place = places[i], group = place / kGroup;
    put(activate(cloud, i).gaussian, blocks[place / kBlock], place % kBlock);
    const float* const sh = &cloud.sh.data()->x + i * (3 + rest);
    const auto at = [&](std::size_t values, std::size_t value) {
      return (group * values + value) * kGroup + place % kGroup;
    };
    for (std::size_t value = 0; value < 3; ++value) harmonics.base[at(3, value)] = sh[value];
    for (std::size_t value = 0; value < rest; ++value) {
      if (harmonics.halves.empty())
        harmonics.rest[at(rest, value)] = sh[3 + value];
      else if (!to_half(sh[3 + value], harmonics.halves[at(rest, value)]))
        exact = false;
    }
  });
  for (const std::uint32_t i : changed)
    include(bounds[places[i] / kBlock], blocks[places[i] / kBlock], places[i] % kBlock);
  return exact;
}

SceneBlocks make_scene(const GaussianCloud& cloud, ThreadPool& pool) {
  const Array<std::uint32_t> order = spatial_order(cloud, pool);
  SceneBlocks scene{make_blocks(cloud, order, pool), {}, make_harmonics(cloud, order, pool)};
  scene.bounds.resize(scene.blocks.size());
  pool.for_each(scene.blocks.size(), 16,
                [&](std::size_t b) { scene.bounds[b] = bounds_of(scene.blocks[b]); });
  return scene;
}

}  // namespace qs::cpu::fast
