// SPDX-License-Identifier: MIT
//
// Stage 1: from the scene to the Gaussians that this view shows.
#pragma once

#include "raster/cpu/frame_context.h"
#include "raster/kernel/blend.h"

namespace qs::cpu {

/// Where a Gaussian can have alpha >= 1/255, so that blending skips pixels for nothing. It only
/// ever errs towards touching: rounding decides nothing here.
struct Reach {
  glm::vec2 half;   ///< pixels around the mean, with a pixel to spare; 0 = nowhere
  float slope;      ///< along a row the falloff is largest at dx = slope * dy
  float threshold;  ///< log2 of the falloff below which alpha < 1/255, with room for rounding

  static Reach of(const Footprint& footprint);
};

/// What blending reads of a visible Gaussian: 48 bytes, so that a random access costs one cache
/// line or two.
struct BlendRecord {
  Splat splat;
  Reach reach;
};

/// The visible Gaussians. They keep slots in ascending order of their index in the cloud, with
/// gaps: every chunk of the cloud owns as many slots as it has Gaussians, so chunks never wait for
/// each other.
struct Visible {
  static constexpr std::size_t kChunk = 2048;

  Array<std::uint32_t> chunk_counts;  ///< used slots of each chunk, from its start
  Array<std::uint32_t> gaussians;     ///< per slot: index in the cloud
  Array<float> depths;                ///< per slot: view z
  Array<Footprint> footprints;        ///< per slot
  Array<BlendRecord> records;         ///< per slot
  std::uint32_t count = 0;            ///< of visible Gaussians

  /// Calls visit(slot) for every visible Gaussian in ascending order of its index.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t chunk = 0; chunk < chunk_counts.size(); ++chunk) {
      for (std::uint32_t k = 0; k < chunk_counts[chunk]; ++k)
        visit(static_cast<std::uint32_t>(chunk * kChunk + k));
    }
  }
};

/// Projects, culls by the frame's mode (a Gaussian without a tile is not visible) and colours.
void preprocess(const FrameContext& frame, Visible& visible);

}  // namespace qs::cpu
