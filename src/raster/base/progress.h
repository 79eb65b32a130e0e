// SPDX-License-Identifier: MIT
//
// How long work reports how far it is and learns that nobody wants it any more.
#pragma once

#include <functional>
#include <stop_token>

#include "raster/base/error.h"

namespace qs {

/// Passed by value into long work. Both parts may be empty.
struct Progress {
  std::function<void(float fraction)>
      report;  ///< 0..1, called from the working thread, never twice at once
  std::stop_token stop;

  /// Reports and throws Cancelled when stop was requested.
  void update(float fraction) const {
    if (stop.stop_requested()) throw Cancelled{};
    if (report) report(fraction);
  }
};

}  // namespace qs
