// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/blend.h"
#include "learn/diff/cuda/color_blend.cuh"
#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/flags.h"

namespace qs::cuda::diff {
namespace {

/// A tile is one block with one thread per pixel. Colours have kChannels channels, of which
/// in.channel_count are used.
template <int kChannels, bool kDepth>
__global__ void __launch_bounds__(kThreads)
    blend_channels(ChannelInput in, GpuPixelBlock out, Pictures<float> pictures) {
  __shared__ SharedSegment segment;
  __shared__ std::uint32_t owners[kSegment];
  const std::uint32_t tile = in.schedule.tile(blockIdx.x);
  const unsigned thread = threadIdx.x;
  const int x = in.tiles.x_of(tile, thread), y = in.tiles.y_of(tile, thread);
  const auto px = static_cast<float>(x), py = static_cast<float>(y);
  const bool inside = in.tiles.contains(x, y);
  const uint2 range = in.tiles.ranges[tile];

  bool live = inside;
  Color<float, kChannels> color(0);
  float transmittance = 1, depth = 0, inverse_depth = 0;
  std::uint32_t last = 0;
  for (std::uint32_t first = range.x; first < range.y; first += kSegment) {
    if (__syncthreads_count(live) == 0) break;
    const std::uint32_t size = min(range.y - first, kSegment);
    segment.load(in.tiles, tile, first, size);
    if (thread < size) owners[thread] = in.tiles.owners[in.tiles.places[first + thread]];
    __syncthreads();
    for (std::uint32_t group = 0; group < size; group += kWarp) {
      unsigned reaching = segment.reaching(group, size);
      for (; reaching != 0; reaching &= reaching - 1) {
        const std::uint32_t entry = group + lowest_bit(reaching);
        Contribution by = segment.contribution(entry, px, py);
        limit_alpha(in.rules, by);
        if (!live || !by.counts) continue;
        const float next = by.behind(transmittance);
        if (next < in.rules.stops_below) {
          live = false;
          continue;
        }
        const float weight = by.alpha * transmittance;
        const std::uint32_t gaussian = owners[entry];
#pragma unroll
        for (int c = 0; c < kChannels; ++c)
          if (c < in.channel_count) color[c] = fmaf(weight, in.channel(gaussian, c), color[c]);
        if constexpr (kDepth) {
          const float z = in.depths[gaussian];
          depth += weight * z;
          inverse_depth += weight / z;
        }
        transmittance = next;
        last = first - range.x + entry + 1;
      }
    }
  }

  if (!inside) return;
  const std::size_t at = in.tiles.index_of(x, y);
#pragma unroll
  for (int c = 0; c < kChannels; ++c) {
    if (c >= in.channel_count) continue;
    const float value = color[c] + transmittance * in.background_of(c);
    out.color[at * static_cast<std::size_t>(in.channel_count) + static_cast<std::size_t>(c)] =
        value;
    if (pictures.color) pictures.color.at(x, y, c) = value;
  }
  out.transmittance[at] = transmittance;
  out.last[at] = last;
  if (pictures.alpha) pictures.alpha.at(x, y) = 1 - transmittance;
  if constexpr (kDepth) {
    out.depth[at] = depth;
    out.inverse_depth[at] = inverse_depth;
    if (pictures.depth) pictures.depth.at(x, y) = depth;
    if (pictures.inverse_depth) pictures.inverse_depth.at(x, y) = inverse_depth;
  }
}

}  // namespace

void blend(const BlendInput& in, const Queue& queue, bool with_depth, Frame& frame,
           const Pictures<float>& out) {
  in.check("blend", with_depth, out.depth || out.inverse_depth);
  in.check_frame("blend", {frame.sizes.width, frame.sizes.height}, in.channel_count);
  queue.throw_if_cancelled();
  frame.sizes = frame.sizes.blended(in.channel_count, with_depth);
  const ListedFrame listed = ListedFrame::of(frame);
  const auto block = block_at<GpuPixelBlock>(frame.pixels, listed.sizes);
  if (frame.sizes.has_states) {
    const auto launch_with = [&](auto is_default, auto has_depth) {
      launch_blend(listed, block,
                   CallersView<is_default(), has_depth()>{in.rules, in.channels, in.background, out,
                                                          listed.depths(block)},
                   stream_of(queue));
    };
    qs::diff::with_flags(launch_with, in.rules.are_default(), with_depth);
    return;
  }
  const ChannelInput input = ChannelInput::of(listed, in);
  with_general_channels(in.channel_count, [&](auto channels) {
    launch("blend",
           with_depth ? blend_channels<channels(), true> : blend_channels<channels(), false>,
           tiles_of(listed.sizes), stream_of(queue), input, block, out);
  });
}

}  // namespace qs::cuda::diff
