// SPDX-License-Identifier: MIT
//
// Errors in vectors against the plain function.
#include "learn/lod/pair_errors.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

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

TEST(PairErrors, equal_the_plain_function) {
  const auto all = all_kinds(300);
  LodPlanes planes;
  planes.resize(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) planes.set(i, all[i]);
  std::vector<float> errors(all.size() + 1);
  for (const float v : {0.0f, 1e-3f, 1.0f, 1e3f})
    for (const float of_size : {0.0f, 0.027f})
      for (const bool antialiased : {false, true})
        for (const std::size_t count :
             {std::size_t{1}, std::size_t{7}, std::size_t{16}, std::size_t{293}}) {
          errors[count] = -1;
          pair_errors(planes, 0, planes, 7, count, {v, of_size, antialiased}, errors.data());
          EXPECT_EQ(errors[count], -1) << "a value behind the end";
          for (std::size_t i = 0; i < count; ++i) {
            const LodGaussian &a = all[i], &b = all[i + 7], node = merged(a, b);
            const float filter = of_size > 0 ? v + 1e-30f +
                                                   of_size * ellipsoid_area(node.covariance) /
                                                       (4 * std::numbers::pi_v<float>)
                                             : v;
            const float plain = merging_error(a, b, node, filter, antialiased);
            // Terms of this size cancel.
            const float size =
                drawn(node, filter).opacity * (ellipsoid_area(node.covariance) / 12 + v);
            EXPECT_NEAR(errors[i], plain, 1e-3f * plain + 2e-5f * size + 1e-9f)
                << i << " " << v << " " << of_size << " " << antialiased;
          }
        }
}

}  // namespace
}  // namespace qs::test
