// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/blocks.h"

#include <atomic>
#include <bit>
#include <cmath>

namespace qs::cpu::fast {

namespace {

/// Members ahead of the one being copied that are fetched: they lie anywhere in the cloud.
constexpr std::size_t kPrefetch = 16;

}  // namespace

Array<Block> make_blocks(const ActivatedCloud& active, std::span<const std::uint32_t> order,
                         ThreadPool& pool) {
  Array<Block> blocks((order.size() + kBlock - 1) / kBlock);
  pool.for_chunks(blocks.size(), 16, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t b = begin; b < end; ++b) {
      Block& block = blocks[b];
      for (std::size_t lane = 0; lane < kBlock; ++lane) {
        const std::size_t i = b * kBlock + lane;
        const ActiveGaussian nobody{glm::vec3(NAN), {}, 0};
        if (i + kPrefetch < order.size())
          __builtin_prefetch(&active.gaussians[order[i + kPrefetch]]);
        const ActiveGaussian& g = i < order.size() ? active.gaussians[order[i]] : nobody;
        block.gaussian[lane] = i < order.size() ? order[i] : 0;
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

Harmonics make_harmonics(const GaussianCloud& cloud, std::span<const std::uint32_t> order,
                         ThreadPool& pool) {
  Harmonics sh;
  sh.degree = cloud.sh_degree;
  const std::size_t groups = (cloud.size() + kBlock - 1) / kBlock * (kBlock / kGroup);
  const std::size_t rest = sh.rest_size() / kGroup, stride = 3 + rest;

  const auto from = [&](std::size_t i) { return &cloud.sh.data()->x + i * stride; };

  // Calls store(group, lane, value of the cloud) for all members of all groups; members behind the
  // last Gaussian are zeros.
  const auto for_each_member = [&](const auto& store) {
    pool.for_chunks(groups * kGroup, 4096, [&](std::size_t begin, std::size_t end, int) {
      const std::vector<float> nobody(stride, 0.0f);
      for (std::size_t i = begin; i < end; ++i) {
        if (i + kPrefetch < order.size()) __builtin_prefetch(from(order[i + kPrefetch]));
        store(i / kGroup, i % kGroup, i < order.size() ? from(order[i]) : nobody.data());
      }
    });
  };

  std::atomic<bool> exact = true;
  sh.base.resize(groups * kGroup * 3);
  sh.halves.resize(groups * sh.rest_size());
  for_each_member([&](std::size_t group, std::size_t lane, const float* values) {
    for (std::size_t k = 0; k < 3; ++k) sh.base[(group * 3 + k) * kGroup + lane] = values[k];
    for (std::size_t k = 0; k < rest && exact; ++k) {
      const std::optional<std::uint16_t> half = exact_half(values[3 + k]);
      if (!half) exact = false;
      sh.halves[(group * rest + k) * kGroup + lane] = half.value_or(0);
    }
  });
  if (exact) return sh;
  sh.halves = {};
  sh.rest.resize(groups * sh.rest_size());
  for_each_member([&](std::size_t group, std::size_t lane, const float* values) {
    for (std::size_t k = 0; k < rest; ++k)
      sh.rest[(group * rest + k) * kGroup + lane] = values[3 + k];
  });
  return sh;
}

std::optional<std::uint16_t> exact_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 31, exponent = bits >> 23 & 0xff, fraction = bits & 0x7fffff;
  if (exponent == 0 && fraction == 0) return static_cast<std::uint16_t>(sign << 15);
  constexpr std::uint32_t kBias = 127 - 15;
  if (exponent <= kBias || exponent >= kBias + 31 || (fraction & 0x1fff) != 0) return std::nullopt;
  return static_cast<std::uint16_t>(sign << 15 | (exponent - kBias) << 10 | fraction >> 13);
}

}  // namespace qs::cpu::fast
