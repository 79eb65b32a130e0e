// SPDX-License-Identifier: MIT
//
// Progress in steps that a progress bar can show.
#pragma once

#include <functional>
#include <utility>

#include "base/progress.h"

namespace qs {

/// Calls `report` only after another 1 %.
inline Progress stepped_progress(std::function<void(float)> report, std::stop_token stop) {
  constexpr float kStep = 0.01f;
  Progress progress;
  progress.stop = std::move(stop);
  progress.report = [report = std::move(report), reported = 0.0f](float fraction) mutable {
    if (fraction < reported + kStep) return;
    reported = fraction;
    report(fraction);
  };
  return progress;
}

}  // namespace qs
