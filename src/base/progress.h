// SPDX-License-Identifier: MIT
//
// Lets long-running work report its progress and find out that it was cancelled.
#pragma once

#include <functional>
#include <stop_token>

#include "base/error.h"

namespace qs {

/// Both members may be empty.
struct Progress {
  /// Receives 0..1. Called from the working thread, never concurrently.
  std::function<void(float fraction)> report;
  std::stop_token stop;

  /// Reports `fraction`. Throws Cancelled when a stop was requested.
  void update(float fraction) const {
    if (stop.stop_requested()) throw Cancelled{};
    if (report) report(fraction);
  }
};

}  // namespace qs
