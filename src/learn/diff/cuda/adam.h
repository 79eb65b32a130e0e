// SPDX-License-Identifier: MIT
//
// A step of Adam for arrays of a caller on the GPU.
#pragma once

#include <cstddef>
#include <cstdint>

#include "learn/diff/cuda/frame.h"
#include "learn/gradient/adam.h"

namespace qs::cuda::diff {

/// An array of four dimensions, the first of which has the rows.
template <class T>
struct Elements {
  T* data;
  std::ptrdiff_t strides[4];

  QS_HD T& at(const std::size_t (&index)[4]) const {
    std::ptrdiff_t place = 0;
    for (int i = 0; i < 4; ++i) place += static_cast<std::ptrdiff_t>(index[i]) * strides[i];
    return data[place];
  }
};

struct AdamArrays {
  std::size_t sizes[4];
  Elements<const float> gradients;
  Elements<float> values, first, second;
  const std::uint8_t* visible;  ///< null: all rows
  std::ptrdiff_t visible_stride;
};

/// Enqueues the step for the rows whose `visible` is not 0. Throws Error(device).
void adam(const AdamArrays& arrays, const AdamRule& rule, const AdamStep& step, float rate,
          const Queue& queue);

}  // namespace qs::cuda::diff
