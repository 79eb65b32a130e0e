// SPDX-License-Identifier: MIT
//
// Stage 3 of the fast pipeline, in two parts. Before binning, the visible Gaussians are sorted by
// depth, then by index; after binning, the tile pairs are sorted by tile. Both sorts are stable, so
// every tile's list is in depth order although the pairs do not store a depth.
#pragma once

#include "raster/cuda/fast/preprocess.cuh"

namespace qs::cuda::fast {

struct DepthOrder {
  DeviceBuffer<std::uint32_t> gaussians;  ///< the visible ones, front to back
  DeviceBuffer<std::uint32_t> other_gaussians, keys, other_keys;

  void reserve(const FrameSize& size);
};

/// Tiles are the keys, in 16 or 32 bits (see FrameSize::uses_16_bit_keys()), Gaussians the values.
/// A frame with macro-tiles uses `gaussians` only.
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

/// Number of digits of the depth key of the farthest corner of the scene's bounding box.
int depth_passes(const FrameContext& frame);

/// Also counts the visible Gaussians.
void sort_by_depth(const FrameContext& frame, const FrameSize& size, const Visible& visible,
                   Scratch& scratch, DepthOrder& order);

/// Also finds the range of every tile. The sorted Gaussians are in `pairs.gaussians`.
void sort_by_tile(const FrameContext& frame, const FrameSize& size, TilePairs& pairs,
                  Scratch& scratch);

}  // namespace qs::cuda::fast
