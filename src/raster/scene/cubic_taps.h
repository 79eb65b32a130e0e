// SPDX-License-Identifier: MIT
//
// Cubic interpolation between pixels (Catmull-Rom).
#pragma once

#include <cmath>

#include "raster/kernel/hd.h"

namespace qs {

/// The four pixels around a position along one axis, and their weights, whose sum is 1.
struct CubicTaps {
  int first;
  float weights[4];
};

QS_HD CubicTaps cubic_taps(double position) {
  const double pixel = std::floor(position);
  const auto t = static_cast<float>(position - pixel);
  return {static_cast<int>(pixel) - 1,
          {t * (t * (1 - 0.5f * t) - 0.5f), 1 + t * t * (1.5f * t - 2.5f),
           t * (0.5f + t * (2 - 1.5f * t)), t * t * (0.5f * t - 0.5f)}};
}

}  // namespace qs
