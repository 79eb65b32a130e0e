// SPDX-License-Identifier: MIT
#pragma once

#include "learn/lod/pair_errors.h"

namespace qs::test {

/// pair_errors() of one pair.
inline float merging_error(const LodGaussian& a, const LodGaussian& b, float v, bool antialiased) {
  LodPlanes first, second;
  for (LodPlanes* planes : {&first, &second}) {
    planes->resize(1);
    planes->set(0, planes == &first ? a : b);
  }
  float error = 0;
  pair_errors(first, 0, second, 0, 1, {v, 0, antialiased}, &error);
  return error;
}

}  // namespace qs::test
