// SPDX-License-Identifier: MIT
// The contributions that a mode drops.
#include <cmath>

#include "app/inspect/heatmap_frame.h"
#include "support/inspector.h"

namespace qs {
namespace {

class Missed : public test::InspectorTest {};

TEST_F(Missed, lossless_modes_miss_nothing_and_the_others_do) {
  const Frame all = render(kBaselineMode);
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const MissedMap map =
        missed_contributions(all, render(mode), size(), settings_.background, pool_);
    if (row_of(mode).lossless) {
      EXPECT_EQ(map.total, 0u) << mode_name(mode);
      EXPECT_EQ(map.largest_alpha, 0) << mode_name(mode);
      EXPECT_EQ(map.largest_error, 0) << mode_name(mode);
    } else {
      EXPECT_GT(map.total, 0u) << mode_name(mode);
      EXPECT_GE(map.largest_alpha, kAlphaMin);
      EXPECT_GT(map.largest_error, 0);
      EXPECT_EQ(map.total, sum_of(map.counts));
      EXPECT_EQ(missed_heatmap(map).total, map.total);
    }
  }
}

TEST_F(Missed, the_error_of_what_is_missed_is_the_error_of_the_image) {
  const Frame all = render(kBaselineMode);
  for (const char* name : {"3dgs", "dualbox"}) {
    const Frame frame = render(find_culler(name));
    const MissedMap map = missed_contributions(all, frame, size(), settings_.background, pool_);
    for (int y = 0; y < camera_.height; ++y) {
      for (int x = 0; x < camera_.width; ++x) {
        float error = 0;
        for (int c = 0; c < 3; ++c)
          error = std::max(error, std::abs(frame.color.at(x, y, c) - all.color.at(x, y, c)));
        ASSERT_NEAR(map.errors[static_cast<std::size_t>(y * camera_.width + x)], error, 1e-4f)
            << name << " " << x << "," << y;
      }
    }
  }
}

}  // namespace
}  // namespace qs
