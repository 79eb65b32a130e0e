// SPDX-License-Identifier: MIT
//
// Stage 3 of the fast pipeline, in two parts around binning: the visible Gaussians by depth, ties
// by index, and later their tile pairs by tile. Both sorts are stable, so a tile's list is in order
// of depth without any pair carrying one.
#pragma once

#include "raster/cuda/fast/scratch.cuh"

namespace qs::cuda::fast {

struct DepthOrder {
  DeviceBuffer<std::uint32_t> gaussians;  ///< visible ones, front to back
  DeviceBuffer<std::uint32_t> other_gaussians, keys, other_keys;

  void reserve(std::size_t size);
};

/// (tile, Gaussian), keys and values apart. Keys are 16 or 32 bits wide, see FrameSize::narrow().
struct TilePairs {
  DeviceBuffer<std::byte> keys, other_keys;
  DeviceBuffer<std::uint32_t> gaussians, other_gaussians;

  void reserve(const FrameSize& size);
  template <class Key>
  Key* keys_as() {
    return reinterpret_cast<Key*>(keys.data());
  }
  template <class Key>
  Key* other_keys_as() {
    return reinterpret_cast<Key*>(other_keys.data());
  }
};

/// How many digits the depth key of the farthest corner of the scene's box has.
int depth_passes(const FrameContext& frame);

/// Also counts the visible ones.
void sort_by_depth(const FrameContext& frame, const FrameSize& size, const Visible& visible,
                   Scratch& scratch, DepthOrder& order);

/// Also finds the range of each tile. The sorted Gaussians are in `pairs.gaussians`.
void sort_by_tile(const FrameContext& frame, const FrameSize& size, TilePairs& pairs,
                  Scratch& scratch);

}  // namespace qs::cuda::fast
