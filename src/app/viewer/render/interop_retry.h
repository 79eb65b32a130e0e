// SPDX-License-Identifier: MIT
//
// Decides if a frame is drawn into a GL texture after frames for which that failed. A frame may
// fail because memory was short for a moment, and on other machines it fails always. So it is tried
// again, after more and more frames that went through host memory.
#pragma once

#include <algorithm>

namespace qs {

class InteropRetry {
 public:
  static constexpr int kFirstPause = 8, kLongestPause = 1024;  ///< frames

  /// True if the next frame is drawn into a texture. Call it once per frame.
  bool tries_next() { return left_ == 0 || --left_ == 0; }

  /// Returns true for the first failure after a frame that worked: the user has not heard of it.
  bool note_failure() {
    const bool is_first = pause_ == 0;
    pause_ = is_first ? kFirstPause : std::min(2 * pause_, kLongestPause);
    left_ = pause_;
    return is_first;
  }
  void note_success() { pause_ = 0; }

 private:
  int pause_ = 0, left_ = 0;  // frames; left_: until the next try
};

}  // namespace qs
