// SPDX-License-Identifier: MIT
#include "io/cloud/fill_cloud.h"

#include <limits>

#include <gtest/gtest.h>

#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

TEST(FillDrawable, removes_impossible_gaussians_and_returns_their_indices_in_order) {
  const GaussianCloud source = test::random_cloud(5000, 1, 1);
  GaussianCloud cloud;
  cloud.resize(source.size(), source.sh_degree);
  const auto is_bad = [](std::size_t i) { return i % 1000 == 7 || i == 4999; };
  const std::vector<std::size_t> removed =
      fill_drawable(cloud, test::pool(3), {}, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          cloud.positions[i] = source.positions[i];
          cloud.log_scales[i] = source.log_scales[i];
          cloud.rotations[i] = source.rotations[i];
          cloud.opacity_logits[i] = source.opacity_logits[i];
          for (std::size_t k = 0; k < 4; ++k) cloud.sh[4 * i + k] = source.sh[4 * i + k];
          if (is_bad(i)) cloud.positions[i].z = std::numeric_limits<float>::quiet_NaN();
        }
      });
  EXPECT_EQ(removed, (std::vector<std::size_t>{7, 1007, 2007, 3007, 4007, 4999}));
  ASSERT_EQ(cloud.size(), 4994u);
  std::size_t kept = 0, wrong = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (is_bad(i)) continue;
    wrong += cloud.positions[kept] != source.positions[i];
    wrong += cloud.sh[4 * kept + 3] != source.sh[4 * i + 3];
    ++kept;
  }
  EXPECT_EQ(wrong, 0u);
}

TEST(FillDrawable, may_leave_nothing) {
  GaussianCloud none;
  EXPECT_TRUE(fill_drawable(none, test::pool(), {}, [](std::size_t, std::size_t) {}).empty());
  GaussianCloud bad = test::single_gaussian({0, 0, 1}, 1, {1, 1, 1}, 0);
  bad.opacity_logits[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(fill_drawable(bad, test::pool(), {}, [](std::size_t, std::size_t) {}).size(), 1u);
  EXPECT_TRUE(bad.empty());
}

TEST(FillDrawable, normalises_rotations) {
  GaussianCloud cloud = test::single_gaussian({0, 0, 1}, 1, {1, 1, 1}, 0);
  fill_drawable(cloud, test::pool(), {}, [&](std::size_t, std::size_t) {
    cloud.rotations[0] = {0, 3, 0, 4};
  });
  EXPECT_EQ(cloud.rotations[0], glm::quat(0, 0.6f, 0, 0.8f));
}

}  // namespace
}  // namespace qs
