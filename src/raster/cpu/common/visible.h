// SPDX-License-Identifier: MIT
//
// Storage for a frame's visible Gaussians, shared by both pipelines. Every chunk of the cloud owns
// a fixed block of slots (some stay unused), so threads fill chunks in parallel without
// synchronising. Slots are in the order in which the pipeline stores the cloud (`classic`: its own,
// `fast`: spatial).
#pragma once

#include <numeric>

#include "raster/cpu/common/frame_context.h"

namespace qs::cpu {

struct VisibleSlots {
  static constexpr std::size_t kChunk = 2048;

  Array<std::uint32_t> chunk_counts;  ///< per chunk: number of used slots, from its start
  Array<std::uint32_t> gaussians;     ///< per slot: index in the cloud
  Array<float> depths;                ///< per slot: view z
  Array<Footprint> footprints;        ///< per slot; pipeline `fast` fills them only for a trace
  std::uint32_t count = 0;            ///< number of visible Gaussians

  static std::size_t chunks_of(std::size_t gaussians) { return (gaussians + kChunk - 1) / kChunk; }

  /// Number of slots of all chunks; the last chunk is also of full size.
  std::size_t slots() const { return chunk_counts.size() * kChunk; }

  void resize(std::size_t gaussian_count) {
    chunk_counts.resize(chunks_of(gaussian_count));
    gaussians.resize(slots());
    depths.resize(slots());
  }

  /// Call it when all chunk_counts are set.
  void count_all() {
    count = std::accumulate(chunk_counts.begin(), chunk_counts.end(), std::uint32_t{0});
  }

  /// Calls visit(slot) for every visible Gaussian, in the order of slots.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t chunk = 0; chunk < chunk_counts.size(); ++chunk) {
      for (std::uint32_t k = 0; k < chunk_counts[chunk]; ++k)
        visit(static_cast<std::uint32_t>(chunk * kChunk + k));
    }
  }
};

}  // namespace qs::cpu
