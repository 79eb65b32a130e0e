// SPDX-License-Identifier: MIT
//
// A step of Adam for arrays of a caller on the GPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

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

/// A step of an array.
struct AdamOrder {
  AdamArrays arrays;
  AdamRule rule;
  AdamStep step;
  float rate;
};

/// Enqueues the steps for the rows whose `visible` is not 0, up to 8 arrays in a launch. Throws
/// Error(device).
void adam(std::span<const AdamOrder> orders, const Queue& queue);

}  // namespace qs::cuda::diff
