// SPDX-License-Identifier: MIT
//
// Where the visible Gaussians of a frame are kept, whichever pipeline found them. They get slots in
// the order in which the pipeline keeps the cloud (`classic`: as it is, `fast`: in space), with
// gaps: every chunk of the cloud owns as many slots as it has Gaussians, so chunks never wait for
// each other.
#pragma once

#include <numeric>

#include "raster/cpu/frame_context.h"

namespace qs::cpu {

struct VisibleSlots {
  static constexpr std::size_t kChunk = 2048;

  Array<std::uint32_t> chunk_counts;  ///< used slots of each chunk, from its start
  Array<std::uint32_t> gaussians;     ///< per slot: index in the cloud
  Array<float> depths;                ///< per slot: view z
  Array<Footprint> footprints;        ///< per slot; of pipeline `fast` only when traced
  std::uint32_t count = 0;            ///< of visible Gaussians

  static std::size_t chunks_of(std::size_t gaussians) { return (gaussians + kChunk - 1) / kChunk; }

  /// Slots of all chunks: those of the last one are whole too.
  std::size_t slots() const { return chunk_counts.size() * kChunk; }

  void resize(std::size_t gaussian_count) {
    chunk_counts.resize(chunks_of(gaussian_count));
    gaussians.resize(slots());
    depths.resize(slots());
  }

  /// To be called when every chunk has its count.
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
