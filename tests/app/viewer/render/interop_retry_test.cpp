// SPDX-License-Identifier: MIT
// The frames that are drawn into GL textures after frames for which that failed.
#include <gtest/gtest.h>

#include "app/viewer/render/gl_frames.h"

namespace qs {
namespace {

// The frames until the next try, that try included.
int frames_to_try(InteropRetry& retry) {
  for (int frame = 1; frame <= 10'000; ++frame) {
    if (retry.tries_next()) return frame;
  }
  return 0;
}

TEST(InteropRetry, one_failure_lasts_for_some_frames_only) {
  InteropRetry retry;
  EXPECT_EQ(frames_to_try(retry), 1);
  EXPECT_TRUE(retry.note_failure()) << "the user is told";
  EXPECT_EQ(frames_to_try(retry), InteropRetry::kFirstPause);
  retry.note_success();
  EXPECT_EQ(frames_to_try(retry), 1);
  EXPECT_TRUE(retry.note_failure());
  EXPECT_EQ(frames_to_try(retry), InteropRetry::kFirstPause);
}

TEST(InteropRetry, failures_in_a_row_are_tried_ever_less_often_and_told_once) {
  InteropRetry retry;
  EXPECT_TRUE(retry.note_failure());
  for (int pause = InteropRetry::kFirstPause; pause < 3 * InteropRetry::kLongestPause; pause *= 2) {
    EXPECT_EQ(frames_to_try(retry), std::min(pause, InteropRetry::kLongestPause));
    EXPECT_FALSE(retry.note_failure());
  }
}

}  // namespace
}  // namespace qs
