// SPDX-License-Identifier: MIT
//
// The order in which tiles are blended: tiles with long lists first, so that no slow block starts
// last. Tiles are grouped into classes by the length of their lists. The order within a class is
// arbitrary; images do not depend on it.
#pragma once

#include "raster/cuda/common/warp.cuh"

namespace qs::cuda {

inline constexpr unsigned kLengthClasses = kWarp;  ///< half octaves, the longest first

/// Twice the binary logarithm of a length > 0, rounded down to a half octave: 0 for 1, 2 for 2, 3
/// for 3, 4 for 4 and 5.
__device__ inline unsigned half_octaves(std::uint32_t length) {
  constexpr int kMantissaBits = 23, kBias = 127;
  const unsigned bits = __float_as_uint(static_cast<float>(length));
  return (bits >> (kMantissaBits - 1)) - 2 * kBias;
}

/// The least length with so many half octaves. No length has 1: then the least length with 2.
__device__ inline std::uint32_t least_length(unsigned half_octaves) {
  return (((2 + half_octaves % 2) << half_octaves / 2) + 1) / 2;
}

/// Lengths of 2^15 and more are in class 0, empty lists in the last class.
__device__ inline unsigned length_class(std::uint32_t length) {
  if (length == 0) return kLengthClasses - 1;
  const unsigned octaves = half_octaves(length);
  return octaves < kLengthClasses - 1 ? kLengthClasses - 2 - octaves : 0;
}

struct ScheduleView {
  const std::uint32_t* class_sizes;  ///< kLengthClasses
  const std::uint32_t* tiles;        ///< kLengthClasses arrays of `count` entries each
  unsigned count;                    ///< number of tiles

  /// The tile that is blended at position `turn`. All lanes of a warp must call it together.
  __device__ unsigned tile(unsigned turn) const {
    const std::uint32_t size = class_sizes[lane_index()];
    const std::uint32_t end = inclusive_sum_of_warp(size);
    const unsigned later = __ballot_sync(kAllLanes, end > turn);
    const unsigned own = lowest_bit(later);
    return tiles[own * count + turn - __shfl_sync(kAllLanes, end - size, own)];
  }
};

}  // namespace qs::cuda
