// SPDX-License-Identifier: MIT
//
// A warp composites a range of a tile's list onto half a tile. It takes 32 list entries at a time,
// a lane each, tests them against its four sub-tiles of 8x4 pixels, and appends them to the rings
// of those that they reach. Eight lanes then process the ring of each sub-tile, four pixels per
// lane. The four rings advance together with different Gaussians, so that little work is spent on
// pixels that a Gaussian does not reach.
#pragma once

#include "raster/cuda/blend_parameters.cuh"
#include "raster/cuda/fast/radix_sort.cuh"
#include "raster/cuda/fast/rings.cuh"

namespace qs::cuda::fast {

using ListInput = BlendInput<KeyRange, BoundedSplat>;

/// Collects Outputs::evaluated and used.
struct Marks {
  std::uint32_t evaluated[kPixels];  ///< entries up to the one at which a pixel stopped
  std::uint8_t* used;                ///< per pair; null: not requested
};

/// kMaps: also fills Marks, and compares alphas with 1/255 as exactly as the CPU does.
template <bool kMaps>
class Walk {
 public:
  static constexpr Cut kCut = kMaps ? Cut::compare : Cut::flush;

  /// (x, y) is the first pixel of the half tile. All pixels of `column` must be set.
  __device__ Walk(const ListInput& in, int x, int y, Rings<kMaps>& rings, Column<kCut>& column,
                  Marks& marks)
      : in_(in),
        x_(static_cast<float>(x)),
        y_(static_cast<float>(y)),
        rings_(rings),
        column_(column),
        marks_(marks) {
    const unsigned lane = lane_index();
    column.x = static_cast<float>(lane % kLanes) - 0.5f * (kSubWidth - 1);
    rings.clear();
  }

  /// Composites the pairs [begin, end). All lanes call it together.
  __device__ void composite(std::uint32_t begin, std::uint32_t end) {
    const unsigned lane = lane_index(), sub = lane / kLanes;
    std::uint32_t gaussian = begin + lane < end ? in_.gaussians[begin + lane] : 0;
    for (std::uint32_t next = begin; next < end;) {
      const unsigned live = live_sub_tiles();
      if (live == 0) break;
      unsigned longest;
      do {
        const std::uint32_t own = next + lane, current = gaussian;
        next += kWarp;
        if (next + lane < end) gaussian = in_.gaussians[next + lane];
        fill(own, own < end, current, live);
        longest = 0;
#pragma unroll
        for (unsigned s = 0; s < kSubTiles; ++s) longest = max(longest, lengths_[s]);
        if (clamps_) clamped_ = longest, clamps_ = false;
      } while (next < end && longest <= kRing - kWarp);

      unsigned shortest = kRing, length = 0;
#pragma unroll
      for (unsigned s = 0; s < kSubTiles; ++s) {
        if ((live >> s & 1) != 0) shortest = min(shortest, lengths_[s]);
        if (s == sub) length = lengths_[s];
      }
      unsigned steps = rounded_up(longest);
      if (next < end) {
        steps = max(shortest / kUnroll * kUnroll, rounded_up(longest - (kRing - kWarp)));
      }
      rings_.pad(head_, length, steps);
      __syncwarp();
      if (kMaps || clamped_ > 0) {
        drain<true>(steps, begin);
      } else {
        drain<false>(steps, begin);
      }
      __syncwarp();
      clamped_ -= min(clamped_, steps);
#pragma unroll
      for (unsigned s = 0; s < kSubTiles; ++s) lengths_[s] -= min(lengths_[s], steps);
    }
  }

 private:
  static __device__ unsigned rounded_up(unsigned steps) {
    return (steps + kUnroll - 1) / kUnroll * kUnroll;
  }

  /// The sub-tiles with a pixel that has not stopped. The rings of the others are emptied.
  __device__ unsigned live_sub_tiles() {
    const unsigned lanes = __ballot_sync(kAllLanes, column_.any_live());
    unsigned live = 0;
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      if ((lanes >> (s * kLanes) & ((1u << kLanes) - 1)) != 0) {
        live |= 1u << s;
      } else {
        lengths_[s] = 0;
      }
    }
    return live;
  }

  /// Appends the Gaussian of this lane, list entry `entry`, to the rings that it reaches.
  __device__ void fill(std::uint32_t entry, bool exists, std::uint32_t gaussian, unsigned live) {
    unsigned reached = 0;
    BoundedSplat splat{};
    bool clamps = false, is_tame = true;
    if (exists) {
      splat = in_.splats[gaussian];
      const float y0 = y_ - splat.y, rows = splat.clamp_rows;
      reached = reached_sub_tiles(splat.ellipse, x_ - splat.x, y0) & live;
      clamps = reached != 0 && y0 <= rows && y0 + (kWarpHeight - 1) >= -rows;
      is_tame = rows < INFINITY;
    }
    clamps_ = clamps_ || __any_sync(kAllLanes, clamps);
    if (__any_sync(kAllLanes, !is_tame)) {
      if (!is_tame) reached = finite_sub_tiles(splat, reached);
    }
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      const bool mine = (reached >> s & 1) != 0;
      const unsigned reaching = __ballot_sync(kAllLanes, mine);
      if (mine) {
        const unsigned place = lengths_[s] + __popc(reaching & lanes_below());
        const unsigned slot = Rings<kMaps>::wrapped(head_ + place);
        rings_.rings[s].store(slot, staged(splat, s));
        if constexpr (kMaps) rings_.places[s][slot] = entry;
      }
      lengths_[s] += __popc(reaching);
    }
  }

  __device__ Staged staged(const BoundedSplat& splat, unsigned s) const {
    const float u = x_ - splat.x + (static_cast<float>(s % 2 * kSubWidth) + 0.5f * (kSubWidth - 1));
    const float v = y_ - splat.y + static_cast<float>(s / 2 * kSubHeight);
    const float along = fmaf(splat.xy, v, splat.xx * u), down = splat.yy * v;
    return {{fmaf(u, along, fmaf(down, v, splat.log2_opacity)), fmaf(splat.xx, u, along), splat.xx,
             fmaf(2.0f, down, fmaf(splat.xy, u, splat.yy))},
            {splat.xy, exp2_flush(2.0f * splat.yy), splat.red - in_.background.x,
             splat.green - in_.background.y},
            splat.blue - in_.background.z};
  }

  /// Those of the sub-tiles `reached` in which the products of a column stay finite. Only rounding
  /// of a very thin Gaussian's conic can violate that.
  __device__ unsigned finite_sub_tiles(const BoundedSplat& splat, unsigned reached) const {
    constexpr float kFar = 0.5f * (kSubWidth - 1), kMaxLog2 = 64.0f;
    unsigned finite = 0;
    for (unsigned s = 0; s < kSubTiles; ++s) {
      const Staged entry = staged(splat, s);
      const float first = fmaf(kFar, fabsf(entry.shape.y), entry.shape.x);
      const float growth = fmaf(kFar, fabsf(entry.rest.x), entry.shape.w);
      if (first < kMaxLog2 && growth < kMaxLog2) finite |= 1u << s;
    }
    return reached & finite;
  }

  template <bool kClamps>
  __device__ void drain(unsigned steps, std::uint32_t begin) {
    const unsigned sub = lane_index() / kLanes;
    const Ring& ring = rings_.rings[sub];
    unsigned at = head_;
    for (unsigned i = 0; i < steps; i += kUnroll) {
#pragma unroll
      for (unsigned k = 0; k < kUnroll; ++k) {
        if constexpr (!kMaps) {
          column_.template add<kClamps>(ring.shape[at + k], ring.rest[at + k], ring.blue[at + k]);
        } else {
          const Column<kCut> before = column_;
          column_.template add<kClamps>(ring.shape[at + k], ring.rest[at + k], ring.blue[at + k]);
          mark(before, rings_.places[sub][at + k], begin);
        }
      }
      at = Rings<kMaps>::wrapped(at + kUnroll);
    }
    head_ = at;
  }

  __device__ void mark(const Column<kCut>& before, std::uint32_t entry, std::uint32_t begin) {
    bool used = false;
    for (int j = 0; j < kPixels; ++j) {
      const Pixel<kCut>&was = before.pixels[j], &is = column_.pixels[j];
      if (was.is_live() && !is.is_live()) marks_.evaluated[j] = entry - begin + 1;
      used = used || (is.is_live() && is.transmittance != was.transmittance);
    }
    if (used && marks_.used != nullptr) marks_.used[entry] = 1;
  }

  const ListInput& in_;
  float x_, y_;
  Rings<kMaps>& rings_;
  Column<kCut>& column_;
  Marks& marks_;
  unsigned head_ = 0, lengths_[kSubTiles] = {};
  bool clamps_ = false;   // the last fill added a Gaussian whose alpha may exceed kAlphaMax
  unsigned clamped_ = 0;  // steps until all such Gaussians are composited
};

}  // namespace qs::cuda::fast
