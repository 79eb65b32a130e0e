// SPDX-License-Identifier: MIT
//
// Composites the lists of tiles to colours of three channels, by the rules of training, and stores
// the values of every pixel that color_sums.cuh needs. Sums are in the same order as on the CPU;
// alphas differ by rounding.
//
// A warp composites 8x4 pixels of a tile, with only those Gaussians of the tile's list that reach
// them. The list of a tile is divided into segments of 256 Gaussians. The state of every pixel in
// front of a segment is stored, so that the backward pass can start in the middle of a list.
#pragma once

#include <glm/vec3.hpp>

#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/segment.cuh"
#include "learn/diff/gaussians.h"
#include "raster/cuda/common/schedule.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/blend.h"

namespace qs::cuda::diff {

static_assert(kThreads == kTilePixels);

/// The arrays that blend_tiles() fills. A kernel parameter.
struct BlendTarget {
  // Per pixel, row by row.
  glm::vec3* color;      ///< over the background, not clamped
  float* transmittance;  ///< behind the last Gaussian
  std::uint32_t* last;   ///< entries of the tile's list up to the last blended entry
  // Per segment: its tile, or kNoTile if no pixel reached the segment, and the states of the tile's
  // pixels in front of it, by thread: x, y, z = the colour so far, w = transmittance.
  std::uint32_t* segment_tiles;
  float4* states;
};

/// The rules, colours, background and pictures of training. A kernel parameter, as the next.
struct TrainedView {
  static constexpr bool kDepths = false;  ///< depths are summed
  glm::vec3 background;

  __device__ qs::diff::Rows<const float> colors() const { return {}; }
  __device__ void limit(Contribution&) const {}
  __device__ float stops_below() const { return kTransmittanceMin; }
  __device__ glm::vec3 background_color() const { return background; }
  __device__ const float* depths() const { return nullptr; }
  __device__ void store_state(std::size_t, const glm::vec2&) const {}
  __device__ void store(int, int, std::size_t, const glm::vec3&, float, const glm::vec2&) const {}
};

/// The view of a caller. `kDefault`: with rules.are_default(), so that nothing is left to limit.
template <bool kDefault, bool kDepth>
struct CallersView {
  static constexpr bool kDepths = kDepth;
  PixelRules<float> rules;
  qs::diff::Rows<const float> channels;  ///< 3; not given: the colours of the splats
  const float* background;               ///< 3; null: 0
  Pictures<float> pictures;              ///< each may be missing
  DepthArrays target;

  __device__ qs::diff::Rows<const float> colors() const { return channels; }
  __device__ void limit(Contribution& by) const {
    if constexpr (!kDefault) limit_alpha(rules, by);
  }
  __device__ float stops_below() const { return kDefault ? kTransmittanceMin : rules.stops_below; }
  __device__ glm::vec3 background_color() const {
    if (background == nullptr) return glm::vec3(0.0f);
    return {background[0], background[1], background[2]};
  }
  __device__ const float* depths() const { return target.z; }
  __device__ void store_state(std::size_t at, const glm::vec2& depth) const {
    target.states[at] = depth;
  }
  /// `at` is the pixel's index; `depth` has the sums of z and 1 / z.
  __device__ void store(int x, int y, std::size_t at, const glm::vec3& color, float transmittance,
                        const glm::vec2& depth) const {
    for (int c = 0; c < 3 && pictures.color; ++c) pictures.color.at(x, y, c) = color[c];
    if (pictures.alpha) pictures.alpha.at(x, y) = 1 - transmittance;
    if constexpr (kDepth) {
      target.depth[at] = depth.x;
      target.inverse_depth[at] = depth.y;
      if (pictures.depth) pictures.depth.at(x, y) = depth.x;
      if (pictures.inverse_depth) pictures.inverse_depth.at(x, y) = depth.y;
    }
  }
};

/// The entries of a segment that reach each warp of a block, in their order.
struct WarpLists {
  static constexpr unsigned kAtOnce = 4;  ///< entries in one read
  alignas(std::uint32_t) std::uint8_t entries[kTilePixels / kWarp][kSegment];

  /// Entry at + k of this warp's list, for k < kAtOnce, is byte k. `at` is a multiple of kAtOnce.
  __device__ std::uint32_t read(unsigned at) const {
    return reinterpret_cast<const std::uint32_t*>(entries[threadIdx.x / kWarp])[at / kAtOnce];
  }

  /// Fills the list of this warp and returns its size. All lanes call it.
  __device__ unsigned fill(const SharedSegment& segment, std::uint32_t size) {
    std::uint8_t* const own = entries[threadIdx.x / kWarp];
    unsigned count = 0;
    __syncwarp();  // the list may be in use
    for (std::uint32_t group = 0; group < size; group += kWarp) {
      const unsigned all = segment.reaching(group, size);
      if ((all >> lane_index() & 1) != 0)
        own[count + static_cast<unsigned>(__popc(all & lanes_below()))] =
            static_cast<std::uint8_t>(group + lane_index());
      count += static_cast<unsigned>(__popc(all));
    }
    __syncwarp();
    return count;
  }
};

/// The pixel of a thread while it is composited.
struct BlendPixel {
  float open;  ///< the transmittance, or 0 if the pixel has stopped
  glm::vec3 color{0};
  float transmittance = 1;
  std::uint32_t last = 0;  ///< entries up to the last blended entry

  __device__ bool live() const { return open > 0.0f; }

  /// `end` counts the tile's entries up to the Gaussian. Returns the Gaussian's weight.
  __device__ float add(const Contribution& by, bool exists, std::uint32_t end, float stops_below) {
    const bool counts = exists && by.counts;
    const float next = by.behind(open);
    const bool blends = counts && !(next < stops_below);
    const float weight = by.alpha * open;
    open = blends ? next : counts ? 0.0f : open;
    if (!blends) return 0;
    color = {fmaf(weight, by.light.z, color.x), fmaf(weight, by.light.w, color.y),
             fmaf(weight, by.blue, color.z)};
    transmittance = next;
    last = end;
    return weight;
  }
};

/// A tile is one block with one thread per pixel.
template <class DrawnView>
__global__ void __launch_bounds__(kThreads)
    blend_tiles(ScheduleView schedule, TilesView in, DrawnView view, BlendTarget out) {
  // Contributions that are computed before the first of them is composited, because they do not
  // depend on each other. The time of the longest list depends on it.
  constexpr unsigned kAtOnce = WarpLists::kAtOnce;
  __shared__ SharedSegment segment;
  __shared__ SharedDepths<DrawnView::kDepths> depths;
  __shared__ WarpLists reaching;
  const std::uint32_t tile = schedule.tile(blockIdx.x);
  const unsigned thread = threadIdx.x;
  const int x = in.x_of(tile, thread), y = in.y_of(tile, thread);
  const auto px = static_cast<float>(x), py = static_cast<float>(y);
  const bool inside = in.contains(x, y);
  const uint2 range = in.ranges[tile];
  std::size_t index = first_segment(range.x, tile);

  BlendPixel pixel{inside ? 1.0f : 0.0f};
  glm::vec2 depth(0.0f);  // sums of z and 1 / z by weight
  std::uint32_t first = range.x;
  for (; first < range.y; first += kSegment, ++index) {
    if (__syncthreads_count(pixel.live()) == 0) break;
    const std::uint32_t size = min(range.y - first, kSegment);
    segment.load(in, tile, first, size, view.colors());
    depths.load(in, view.depths(), first, size);
    if (thread == 0) out.segment_tiles[index] = tile;
    out.states[index * kTilePixels + thread] = {pixel.color.x, pixel.color.y, pixel.color.z,
                                                pixel.transmittance};
    if constexpr (DrawnView::kDepths) view.store_state(index * kTilePixels + thread, depth);
    __syncthreads();
    bool any = __any_sync(kAllLanes, pixel.live());
    const unsigned count = any ? reaching.fill(segment, size) : 0;
    for (unsigned at = 0; at < count && any; at += kAtOnce) {
      const std::uint32_t read = reaching.read(at);
      std::uint32_t entries[kAtOnce];
      Contribution by[kAtOnce];
#pragma unroll
      for (unsigned k = 0; k < kAtOnce; ++k) {
        entries[k] = read >> (8 * k) & 0xff;
        by[k] = segment.contribution(entries[k], px, py);
        view.limit(by[k]);
      }
#pragma unroll
      for (unsigned k = 0; k < kAtOnce; ++k) {
        const float weight =
            pixel.add(by[k], at + k < count, first - range.x + entries[k] + 1, view.stops_below());
        // Entries behind the end of the list are arbitrary and may have no depth.
        if constexpr (DrawnView::kDepths)
          if (weight > 0) depth = sum_by_weight(depth, weight, depths, entries[k]);
      }
      any = __any_sync(kAllLanes, pixel.live());
    }
  }
  // Segments that no pixel reached have no gradient. The backward pass writes zeros for them.
  for (std::uint32_t rest = first + kSegment * thread; rest < range.y; rest += kSegment * kThreads)
    out.segment_tiles[first_segment(range.x, tile) + (rest - range.x) / kSegment] = tile;

  if (!inside) return;
  const std::size_t at = in.index_of(x, y);
  const glm::vec3 color = pixel.color + pixel.transmittance * view.background_color();
  out.color[at] = color;
  out.transmittance[at] = pixel.transmittance;
  out.last[at] = pixel.last;
  view.store(x, y, at, color, pixel.transmittance, depth);
}

/// Enqueues the blending of a frame with states.
template <class DrawnView>
void launch_blend(const ListedFrame& listed, const GpuPixelBlock& block, const DrawnView& view,
                  cudaStream_t stream) {
  const unsigned tiles = tiles_of(listed.sizes);
  check(cudaMemsetAsync(block.segment_tiles, 0xff,
                        segments_of(listed.sizes.pairs, tiles) * sizeof(std::uint32_t), stream),
        "blend");
  launch("blend", blend_tiles<DrawnView>, tiles, stream, listed.schedule(), listed.tiles(), view,
         BlendTarget{block.colors(), block.transmittance, block.last, block.segment_tiles,
                     block.states});
}

}  // namespace qs::cuda::diff
