// SPDX-License-Identifier: MIT
//
// The inputs that the kernels of blend() and blend_backward() share.
#pragma once

#include "learn/diff/channels.h"
#include "learn/diff/cuda/blend.h"
#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/segment.cuh"
#include "raster/kernel/blend.h"

namespace qs::cuda::diff {

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
