// SPDX-License-Identifier: MIT
//
// The data between the stages of both pipelines, and the stages sort and bin of `classic`, which
// training calls too: visible Gaussians -> depth order -> tile lists.
#pragma once

#include <cstdint>
#include <functional>
#include <numeric>

#include <glm/vec2.hpp>

#include "raster/cpu/common/frame_context.h"
#include "raster/kernel/constants.h"
#include "raster/kernel/cull/culler.h"
#include "raster/kernel/cull/mode_pairs.h"
#include "raster/scene/radix_sort.h"

namespace qs::cpu {

/// Conservative bound of the pixels with alpha >= 1/255, used to skip pixels cheaply. It may
/// include other pixels but never excludes such a pixel.
struct PixelBound {
  glm::vec2 half;   ///< half size in pixels of a box around the mean; 0 = no pixel
  float slope;      ///< along a row the falloff is largest at dx = slope * dy
  float threshold;  ///< pixels with a smaller log2 of the falloff have alpha < 1/255

  static PixelBound of(const Footprint& footprint) {
    if (!(footprint.gamma > 0.0f)) return {{0, 0}, 0, 0};
    return {extents(footprint).max + 1.0f, footprint.covariance.xy / footprint.covariance.yy,
            kLog2OfFalloff * footprint.gamma - kLog2Slack};
  }
};

/// Storage for a frame's visible Gaussians. Every chunk of the cloud owns a fixed block of slots
/// (some stay unused), so threads fill chunks in parallel without synchronising. Slots are in the
/// order in which the pipeline stores the cloud (`classic`: its own, `fast`: spatial).
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
    for (std::size_t chunk = 0; chunk < chunk_counts.size(); ++chunk)
      for (std::uint32_t k = 0; k < chunk_counts[chunk]; ++k)
        visit(static_cast<std::uint32_t>(chunk * kChunk + k));
  }
};

/// Keys: bits of the depths, values: slots, by ascending (key, index in the cloud).
struct DepthOrder : SortItems {
  const Array<std::uint32_t>& slots() const { return values; }
};

struct TileLists {
  std::vector<std::uint64_t> begin;  ///< tiles + 1 offsets into `slots`
  Array<std::uint32_t> slots;        ///< slots of VisibleSlots, per tile front to back

  std::uint64_t pairs() const { return begin.empty() ? 0 : begin.back(); }
  std::uint32_t pairs(std::size_t tile) const {
    return static_cast<std::uint32_t>(begin[tile + 1] - begin[tile]);
  }

  std::vector<std::uint64_t> cursors;       ///< scratch
  std::vector<std::int64_t> column_counts;  ///< scratch of pipeline `fast`
};

/// Stage 2: sorts the visible Gaussians front to back. Both CPU pipelines sort before they bin, so
/// that tile lists are filled in order and pairs need no sort.
void sort(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order);

/// Stage 3: lists every visible Gaussian in the tiles that the culling mode assigns to it. Throws
/// Error(device) if the lists do not fit into memory.
void bin(const FrameContext& frame, const VisibleSlots& visible, const DepthOrder& order,
         TileLists& lists);

/// Throws Error(device) if lists of `pairs` entries need more than half of the machine's memory.
void refuse_if_too_many(std::uint64_t pairs);

/// The Gaussian in a slot as the blend stage sees it.
using SplatOf = std::function<Splat(std::uint32_t slot)>;

/// Copies counts, and the requested pairs and trace, from the tile lists to `result`, whose grid is
/// already set.
void collect(const FrameContext& frame, const VisibleSlots& visible, const TileLists& lists,
             const SplatOf& splat_of, const Outputs& outputs, Frame& result);

/// The sums of Outputs::mode_pairs, for both pipelines: each worker adds the counts of its chunks
/// to counts of its own.
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
