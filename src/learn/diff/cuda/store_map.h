// SPDX-License-Identifier: MIT
//
// Copies of a frame's maps on the GPU, for callers with arrays of their own there.
#pragma once

#include <cstdint>

#include "learn/diff/cuda/frame.h"
#include "learn/diff/strided_arrays.h"

namespace qs::cuda::diff {

/// A map of height x width x channels values on the GPU, one after the other.
struct PackedMap {
  const float* values;
  int height, width, channels;
};

/// Enqueues a copy into an array on the GPU, also as 8 bits by to_8bit() of image.h. Throws
/// Error(device).
void store_map(const PackedMap& map, const qs::diff::Pixels<float>& to, const Queue& queue);
void store_map(const PackedMap& map, const qs::diff::Pixels<std::uint8_t>& to, const Queue& queue);

}  // namespace qs::cuda::diff
