// SPDX-License-Identifier: MIT
//
// Errors of many pairs in vectors. merging_test.cpp compares them with sums over pixels.
#include "learn/lod/pair_errors.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "support/lod_errors.h"

namespace qs::test {
namespace {

// Leaves, nodes and nodes of many layers, also flat and invisible ones.
std::vector<LodGaussian> all_kinds(std::size_t count) {
  std::mt19937 random(7);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random()) / 4294967296.0f;
  };
  std::vector<LodGaussian> all(count);
  for (std::size_t i = 0; i < count; ++i) {
    LodGaussian& g = all[i];
    g.mean = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    const float a = std::exp2(uniform(-12, 0)), b = std::exp2(uniform(-12, 0));
    const float angle = uniform(0, 3), c = std::cos(angle), s = std::sin(angle);
    g.covariance = {a * c * c + b * s * s,
                    (a - b) * c * s,
                    0,
                    a * s * s + b * c * c,
                    0,
                    i % 5 == 0 ? 0 : std::exp2(uniform(-12, 0))};
    for (float& value : g.color) value = uniform(-0.5f, 0.5f);
    set_opacity(g, i % 11 == 0 ? 0 : uniform(0, 1));
    if (i % 3 == 0 && i > 20) {
      g = merged(g, all[i - 20]);
      if (i % 2 == 0) g.mass *= 9, g.opacities *= 5;
    }
  }
  return all;
}

TEST(PairErrors, do_not_depend_on_their_place_in_the_list) {
  const auto all = all_kinds(300);
  LodPlanes planes;
  planes.resize(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) planes.set(i, all[i]);
  std::vector<float> errors(all.size() + 1);
  for (const float v : {0.0f, 1e-3f, 1.0f, 1e3f})
    for (const bool antialiased : {false, true})
      for (const std::size_t count :
           {std::size_t{1}, std::size_t{7}, std::size_t{16}, std::size_t{17}, std::size_t{293}}) {
        errors[count] = -1;
        pair_errors(planes, 0, planes, 7, count, {v, 0, antialiased}, errors.data());
        EXPECT_EQ(errors[count], -1) << "a value behind the end";
        for (std::size_t i = 0; i < count; ++i)
          ASSERT_EQ(errors[i], merging_error(all[i], all[i + 7], v, antialiased)) << i;
      }
}

TEST(PairErrors, may_be_judged_at_a_share_of_the_node) {
  const auto all = all_kinds(2);
  LodPlanes planes;
  planes.resize(2);
  for (std::size_t i = 0; i < 2; ++i) planes.set(i, all[i]);
  float error = 0;
  pair_errors(planes, 0, planes, 1, 1, {0.01f, 0.027f, false}, &error);
  const float area = ellipsoid_area(merged(all[0], all[1]).covariance);
  const float v = 0.01f + 0.027f * area / (4 * std::numbers::pi_v<float>);
  EXPECT_NEAR(error / merging_error(all[0], all[1], v, false), 1, 1e-4);
}

}  // namespace
}  // namespace qs::test
