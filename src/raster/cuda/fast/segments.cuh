// SPDX-License-Identifier: MIT
//
// Long lists are cut into segments that many warps composite at the same time. Every segment is
// composited first as if nothing were in front of it, which gives its colour and transmittance. A
// pixel stops in the segment in which the product of transmittances falls below kTransmittanceMin.
// Such segments are composited again for those pixels, from their true transmittance, so the stop
// rule stays exact. At last the segments of a tile are joined, front to back.
#pragma once

#include "raster/cuda/fast/scratch.cuh"

namespace qs::cuda::fast {

/// Lists are cut if they are longer than this, and than this part of all pairs. Otherwise other
/// tiles keep the GPU busy meanwhile.
inline constexpr std::uint32_t kLongList = 2048, kLongPart = 1024;

inline constexpr std::uint32_t kSegment = 512;      ///< list entries at least
inline constexpr std::uint32_t kMaxSegments = 256;  ///< of a list

QS_HD bool is_long(std::uint32_t length, std::uint32_t listed) {
  return length > kLongList && length > listed / kLongPart;
}

/// List entries per segment of a list of `length` entries. The last segment may be shorter.
QS_HD std::uint32_t segment_length(std::uint32_t length) {
  const std::uint32_t share = (length + kMaxSegments - 1) / kMaxSegments;
  return share > kSegment ? share : kSegment;
}

QS_HD std::uint32_t segment_count(std::uint32_t length) {
  const std::uint32_t each = segment_length(length);
  return (length + each - 1) / each;
}

}  // namespace qs::cuda::fast
