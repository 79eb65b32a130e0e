// SPDX-License-Identifier: MIT
//
// The largest number of tile pairs of a view.
#pragma once

#include <cstdint>
#include <string>

#include "base/error.h"

namespace qs::cuda {

/// Pairs are counted in 64 bits but indexed with 31.
inline constexpr std::uint64_t kMaxPairs = 0x7fffffff;

/// Throws Error(device) if a view lists more tile pairs than can be indexed.
inline void require_indexable(std::uint64_t tile_pairs) {
  if (tile_pairs <= kMaxPairs) return;
  throw Error(ErrorKind::device, "cuda: bin: this view lists " + std::to_string(tile_pairs) +
                                     " tile pairs, at most " + std::to_string(kMaxPairs) +
                                     " can be sorted");
}

}  // namespace qs::cuda
