// SPDX-License-Identifier: MIT
//
// Compares frames of a set of drawn Gaussians with frames of a cloud of these Gaussians alone.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "raster/kernel/half.h"
#include "raster/scene/cloud_order.h"
#include "support/gpu.h"
#include "support/scenes.h"

namespace qs::test {

struct DrawnSet {
  std::string name;
  GaussianSet set;
};

/// Sets that leave out nothing, everything, single Gaussians, whole blocks and parts of blocks.
inline std::vector<DrawnSet> drawn_sets(const GaussianCloud& cloud) {
  const std::size_t size = cloud.size();
  const auto where = [&](const auto& has) { return GaussianSet::where(size, pool(), has); };
  const std::vector<std::uint32_t> order = morton_order(cloud);
  GaussianSet half_of_space(size);
  for (std::size_t i = 0; i < size / 2; ++i) half_of_space.add(order[i]);
  return {{"all", where([](std::size_t) { return true; })},
          {"none", GaussianSet(size)},
          {"the first", where([](std::size_t i) { return i == 0; })},
          {"the last", where([=](std::size_t i) { return i + 1 == size; })},
          {"all but the first", where([](std::size_t i) { return i != 0; })},
          {"every second", where([](std::size_t i) { return i % 2 == 1; })},
          {"every 256th", where([](std::size_t i) { return i % 256 == 255; })},
          {"the second half", where([=](std::size_t i) { return i >= size / 2; })},
          {"half of space", half_of_space},
          {"right of the middle", where([&](std::size_t i) { return cloud.positions[i].x > 0; })},
          {"scattered", where([](std::size_t i) { return i * 2654435761u >> 7 & 1; })}};
}

/// The same values in every bit.
template <class Values>
void expect_bits(const Values& values, const Values& expected, const char* what) {
  ASSERT_EQ(values.size(), expected.size()) << what;
  if (values.empty()) return;
  EXPECT_EQ(std::memcmp(values.data(), expected.data(), values.size() * sizeof values[0]), 0)
      << what;
}

/// `drawn` is a frame of the set, and `rest` one of select(cloud, set.numbers()).
inline void expect_frame_of_rest(Frame drawn, const Frame& rest, const GaussianSet& set) {
  expect_bits(drawn.color.values, rest.color.values, "colours");
  expect_bits(drawn.pairs, rest.pairs, "pairs");
  expect_bits(drawn.evaluated, rest.evaluated, "evaluated");
  expect_bits(drawn.used, rest.used, "used");
  expect_bits(drawn.depth.alpha, rest.depth.alpha, "alpha");
  expect_bits(drawn.depth.expected, rest.depth.expected, "expected depth");
  expect_bits(drawn.depth.median, rest.depth.median, "median depth");
  EXPECT_EQ(drawn.mode_pairs, rest.mode_pairs);
  EXPECT_EQ(drawn.stats.gaussians, rest.stats.gaussians);
  EXPECT_EQ(drawn.stats.visible, rest.stats.visible);
  EXPECT_EQ(drawn.stats.tile_pairs, rest.stats.tile_pairs);
  EXPECT_EQ(drawn.stats.max_pairs_in_a_tile, rest.stats.max_pairs_in_a_tile);
  EXPECT_EQ(drawn.stats.used_pairs, rest.stats.used_pairs);
  // The trace has the indices of the whole cloud.
  Trace trace = rest.trace;
  const std::vector<std::uint32_t> numbers = set.numbers();
  for (std::uint32_t& gaussian : trace.gaussians) gaussian = numbers[gaussian];
  for (std::uint32_t& gaussian : trace.listed) gaussian = numbers[gaussian];
  EXPECT_EQ(difference(drawn.trace, trace), "");
  expect_bits(drawn.trace.splats, trace.splats, "splats");
}

/// Replaces every `step`-th Gaussian by a Gaussian of `other`, which has the same size and degree.
/// Returns their indices, in no order.
inline std::vector<std::uint32_t> replace_every(std::size_t step, const GaussianCloud& other,
                                                GaussianCloud& cloud) {
  std::vector<std::uint32_t> changed;
  const auto width = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  for (std::size_t i = (cloud.size() - 1) / step * step;; i -= step) {
    changed.push_back(static_cast<std::uint32_t>(i));
    cloud.positions[i] = other.positions[i];
    cloud.log_scales[i] = other.log_scales[i];
    cloud.rotations[i] = other.rotations[i];
    cloud.opacity_logits[i] = other.opacity_logits[i];
    std::copy_n(&other.sh[i * width], width, &cloud.sh[i * width]);
    if (i == 0) return changed;
  }
}

/// The cloud with coefficients that halves can hold.
inline GaussianCloud with_halves(GaussianCloud cloud) {
  for (glm::vec3& color : cloud.sh)
    for (int c = 0; c < 3; ++c) color[c] = float_of_half(nearest_half(color[c]));
  return cloud;
}

/// Everything that a frame of a mode can have.
inline Outputs all_outputs(CullMode mode) {
  Outputs outputs;
  outputs.evaluated = outputs.depth = outputs.trace = outputs.mode_pairs = true;
  outputs.pairs = outputs.used = mode != kReferenceMode;
  return outputs;
}

}  // namespace qs::test
