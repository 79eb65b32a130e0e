// SPDX-License-Identifier: MIT
//
// The sums of Outputs::mode_pairs, for both pipelines: each worker adds the counts of its chunks to
// counts of its own.
#pragma once

#include "raster/cpu/common/frame_context.h"
#include "raster/kernel/cull/mode_pairs.h"

namespace qs::cpu {

class ModeSums {
 public:
  void begin(const ThreadPool& pool) { sums_.assign(static_cast<std::size_t>(pool.size()), {}); }

  void add(int worker, const ModeCounts& counts) {
    ModeCounts& sum = sums_[static_cast<std::size_t>(worker)];
    for (int i = 0; i < kCullerCount; ++i) {
      sum.tile_pairs[i] += counts.tile_pairs[i];
      sum.visible[i] += counts.visible[i];
    }
  }

  /// Sets Frame::mode_pairs.
  void store(Frame& result) const {
    result.mode_pairs.assign(kCullerCount, {});
    for (const ModeCounts& sum : sums_) {
      for (std::size_t i = 0; i < kCullerCount; ++i) {
        result.mode_pairs[i].tile_pairs += sum.tile_pairs[i];
        result.mode_pairs[i].visible += sum.visible[i];
      }
    }
  }

 private:
  std::vector<ModeCounts> sums_;
};

}  // namespace qs::cpu
