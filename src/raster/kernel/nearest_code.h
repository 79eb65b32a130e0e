// SPDX-License-Identifier: MIT
//
// The search for the nearest code of a residual codebook (raster/field/residual_codebook.h).
#pragma once

#include <cmath>

#include "raster/kernel/hd.h"

namespace qs {

/// The number of the code that is nearest to `vector`, of `count` codes one after the other; of
/// equally near codes the first.
QS_HD unsigned nearest_code(const float* codes, unsigned count, unsigned dimensions,
                            const float* vector) {
  unsigned best = 0;
  float least = INFINITY;
  for (unsigned number = 0; number < count; ++number) {
    float distance = 0;
    for (unsigned k = 0; k < dimensions; ++k) {
      const float difference = vector[k] - codes[number * dimensions + k];
      distance += difference * difference;
    }
    if (distance < least) {
      least = distance;
      best = number;
    }
  }
  return best;
}

}  // namespace qs
