// SPDX-License-Identifier: MIT
//
// The arrays in the blocks of a frame and of its first pass's scratch memory, see frame.h, and the
// inputs that the kernels of blend() and blend_backward() share.
#pragma once

#include "learn/diff/block_arrays.h"
#include "learn/diff/channels.h"
#include "learn/diff/cuda/blend.h"
#include "learn/diff/cuda/frame.h"
#include "learn/diff/cuda/tiles.cuh"

namespace qs::cuda::diff {

inline cudaStream_t stream_of(const Queue& queue) {
  return static_cast<cudaStream_t>(queue.stream);
}
inline TileGrid grid_of(const GpuHeldSizes& sizes) {
  return TileGrid::of_image(sizes.width, sizes.height);
}
inline unsigned tiles_of(const GpuHeldSizes& sizes) {
  return static_cast<unsigned>(grid_of(sizes).count());
}

/// The derivative by view z from GaussianSums::depths.
__device__ inline float depth_gradient(const glm::vec2& sums, float z) {
  return sums.x - sums.y / (z * z);
}

struct GpuGaussianBlock {
  unsigned long long* total;    ///< pairs
  std::uint32_t* tile_counts;   ///< 0: no tile lists it; then the next three are undefined
  std::uint32_t* first_places;  ///< the first place of its pairs
  float* depths;                ///< view z
  ListedSplat* splats;
  std::uint8_t* projected;  ///< 1 if it has a row in Boundary

  static GpuGaussianBlock of(BlockArrays& block, const GpuHeldSizes& sizes) {
    GpuGaussianBlock result{};
    // First, so that each splat is in two sectors of the memory.
    result.splats = block.next<ListedSplat>(sizes.gaussians);
    result.total = block.next<unsigned long long>(1);
    result.tile_counts = block.next<std::uint32_t>(sizes.gaussians);
    result.first_places = block.next<std::uint32_t>(sizes.gaussians);
    result.depths = block.next<float>(sizes.gaussians);
    result.projected = block.next<std::uint8_t>(sizes.gaussians);
    return result;
  }
};

struct GpuPairBlock {
  std::uint32_t* owners;                   ///< per place: its Gaussian
  std::uint32_t* places;                   ///< the lists of all tiles, front to back
  uint2* ranges;                           ///< per tile: its list is [x, y)
  std::uint32_t *class_sizes, *scheduled;  ///< see ScheduleView

  static GpuPairBlock of(BlockArrays& block, const GpuHeldSizes& sizes) {
    GpuPairBlock result{};
    result.owners = block.next<std::uint32_t>(sizes.pairs);
    result.places = block.next<std::uint32_t>(sizes.pairs);
    result.ranges = block.next<uint2>(tiles_of(sizes));
    result.class_sizes = block.next<std::uint32_t>(kLengthClasses);
    result.scheduled = block.next<std::uint32_t>(std::size_t{kLengthClasses} * tiles_of(sizes));
    return result;
  }
};

struct GpuPixelBlock {
  float* color;                  ///< `channels` each, over the background, not clamped
  float* transmittance;          ///< behind the last Gaussian
  std::uint32_t* last;           ///< entries of the tile's list up to the last blended entry
  float *depth, *inverse_depth;  ///< null without depths
  // Null without states, see BlendTarget and DepthArrays.
  std::uint32_t* segment_tiles;
  float4* states;
  glm::vec2* depth_states;

  glm::vec3* colors() const { return reinterpret_cast<glm::vec3*>(color); }  ///< of 3 channels

  static GpuPixelBlock of(BlockArrays& block, const GpuHeldSizes& sizes) {
    GpuPixelBlock result{};
    const std::size_t segments = segments_of(sizes.pairs, tiles_of(sizes));
    if (sizes.has_states) result.states = block.next<float4>(segments * kTilePixels);
    result.color = block.next<float>(sizes.pixels() * sizes.channels);
    result.transmittance = block.next<float>(sizes.pixels());
    result.last = block.next<std::uint32_t>(sizes.pixels());
    if (sizes.has_depth) {
      result.depth = block.next<float>(sizes.pixels());
      result.inverse_depth = block.next<float>(sizes.pixels());
    }
    if (sizes.has_states) result.segment_tiles = block.next<std::uint32_t>(segments);
    if (sizes.has_states && sizes.has_depth)
      result.depth_states = block.next<glm::vec2>(segments * kTilePixels);
    return result;
  }
};

/// Scratch memory of project() and of list() after it.
struct ProjectScratch {
  FootprintArrays footprints;

  static ProjectScratch of(BlockArrays& block, const GpuHeldSizes& sizes) {
    ProjectScratch result{};
    result.footprints.means = block.next<float4>(sizes.gaussians);
    result.footprints.conics = block.next<float4>(sizes.gaussians);
    result.footprints.levels = block.next<float2>(sizes.gaussians);
    return result;
  }
};

/// Scratch memory of list().
struct ListScratch {
  SortEntry* entries;
  std::uint32_t *tiles, *slots, *sizes;

  static ListScratch of(BlockArrays& block, const GpuHeldSizes& sizes) {
    ListScratch result{};
    result.entries = block.next<SortEntry>(sizes.pairs);
    result.tiles = block.next<std::uint32_t>(sizes.pairs);
    result.slots = block.next<std::uint32_t>(sizes.pairs);
    result.sizes = block.next<std::uint32_t>(tiles_of(sizes));
    return result;
  }
};

/// The frame as the kernels of the second pass read it.
struct ListedFrame {
  GpuHeldSizes sizes;
  GpuGaussianBlock gaussians;
  GpuPairBlock pairs;

  static ListedFrame of(const Frame& frame) {
    return {frame.sizes, block_at<GpuGaussianBlock>(frame.gaussians, frame.sizes),
            block_at<GpuPairBlock>(frame.pairs, frame.sizes)};
  }

  TilesView tiles() const {
    return {pairs.ranges,           pairs.places, pairs.owners, gaussians.splats,
            grid_of(sizes).columns, sizes.width,  sizes.height};
  }
  /// The lists of the first `count` Gaussians.
  ListInput input(std::uint32_t count, const FootprintArrays& footprints,
                  const ListScratch& unsorted) const {
    return {count,
            gaussians.tile_counts,
            gaussians.first_places,
            footprints,
            grid_of(sizes),
            {gaussians.total, sizes.pairs, reinterpret_cast<std::uint32_t*>(gaussians.depths),
             pairs.owners, unsorted.tiles, unsorted.slots, unsorted.entries, pairs.places,
             unsorted.sizes, pairs.ranges, pairs.class_sizes, pairs.scheduled, tiles_of(sizes)}};
  }
  ScheduleView schedule() const { return {pairs.class_sizes, pairs.scheduled, tiles_of(sizes)}; }
  DepthArrays depths(const GpuPixelBlock& pixels) const {
    return {gaussians.depths, pixels.depth_states, pixels.depth, pixels.inverse_depth};
  }
};

/// with_channels() for the general kernels. Colours of three channels have states and kernels of
/// their own.
template <class F>
void with_general_channels(int channels, const F& f) {
  with_channels(channels, [&](auto size) {
    if constexpr (size() != 3) f(size);
  });
}

/// A kernel parameter.
struct ChannelInput {
  static ChannelInput of(const ListedFrame& frame, const BlendInput& in) {
    return {frame.tiles(),    frame.schedule(), frame.gaussians.depths, in.rules,
            in.channel_count, in.channels,      in.background};
  }

  TilesView tiles;
  ScheduleView schedule;
  const float* depths;  ///< per Gaussian
  PixelRules<float> rules;
  int channel_count;
  qs::diff::Rows<const float> channels;
  const float* background;

  /// Channel c of a Gaussian, whose splat is `splat`.
  __device__ float channel(std::uint32_t gaussian, int c) const {
    if (channels) return channels.at(gaussian, c);
    return tiles.splats[gaussian].splat.color[c];
  }
  __device__ float background_of(int c) const {
    return background != nullptr ? background[c] : 0.0f;
  }
};

}  // namespace qs::cuda::diff
