// SPDX-License-Identifier: MIT
//
// A warp composites a range of a tile's list onto half a tile. It takes 32 list entries at a time,
// a lane each, tests them against its four sub-tiles of 8x4 pixels, and appends each Gaussian to
// the rings of the sub-tiles that it reaches. Eight lanes then process the ring of each sub-tile,
// four pixels per lane. The four rings advance together with different Gaussians, so that little
// work is spent on pixels that a Gaussian does not reach.
#pragma once

#include "raster/cuda/fast/column.cuh"
#include "raster/cuda/fast/scratch.cuh"

namespace qs::cuda::fast {

/// The pixels of a warp: the upper or lower half of a tile, and this lane's column of it.
struct HalfTile {
  int x0, y0;  ///< of the first pixel
  int x, y;    ///< of the lane's first pixel

  __device__ HalfTile(unsigned tile, unsigned half, int columns)
      : x0(static_cast<int>(tile % columns * kTileSize)),
        y0(static_cast<int>(tile / columns * kTileSize + half * kHalfTileHeight)) {
    const unsigned lane = lane_index(), sub = lane / kLanes;
    x = x0 + static_cast<int>(sub % 2 * kSubWidth + lane % kLanes);
    y = y0 + static_cast<int>(sub / 2 * kSubHeight);
  }

  /// Position of the lane's pixel j in its tile, row by row.
  __device__ unsigned place(int j) const {
    return static_cast<unsigned>((y + j) % kTileSize * kTileSize + x % kTileSize);
  }
};

/// Collects Outputs::evaluated and used.
struct Marks {
  std::uint32_t evaluated[kPixels];  ///< list entries up to the entry at which the pixel stopped
  std::uint8_t* used;                ///< per pair; null: not requested
};

/// kMaps: also fills Marks, and compares alphas with 1/255 as exactly as the CPU does.
template <bool kMaps, Rows kRows>
class Walk {
 public:
  static constexpr Cut kCut = kMaps ? Cut::compare : Cut::flush;

  /// All pixels of `column` must be set.
  __device__ Walk(const ListInput& in, const HalfTile& half, Rings<kMaps>& rings,
                  Column<kCut>& column, Marks& marks)
      : in_(in),
        x_(static_cast<float>(half.x0)),
        y_(static_cast<float>(half.y0)),
        rings_(rings),
        column_(column),
        marks_(marks) {
    const unsigned lane = lane_index();
    lanes_below_ = lanes_below();
    column.x = static_cast<float>(lane % kLanes) - 0.5f * (kSubWidth - 1);
    rings.clear();
  }

  /// Composites the pairs [begin, end). All lanes call it together.
  __device__ void composite(std::uint32_t begin, std::uint32_t end) {
    if (begin == end) return;
    const unsigned lane = lane_index(), sub = lane / kLanes;
    std::uint32_t gaussian = in_.gaussians[min(begin + lane, end - 1)];
    for (std::uint32_t next = begin; next < end;) {
      const unsigned live = live_sub_tiles();
      if (live == 0) break;
      unsigned longest;
      do {
        const std::uint32_t own = next + lane, current = gaussian;
        next += kWarp;
        gaussian = in_.gaussians[min(next + lane, end - 1)];
        const bool clamps = fill(own, own < end, current, live);
        longest = 0;
#pragma unroll
        for (unsigned s = 0; s < kSubTiles; ++s) longest = max(longest, lengths_[s]);
        if (clamps) clamped_ = longest;
      } while (next < end && longest <= kRing - kWarp);

      unsigned steps = rounded_up(longest);
      unsigned shortest = kRing, length = 0;
#pragma unroll
      for (unsigned s = 0; s < kSubTiles; ++s) {
        if ((live >> s & 1) != 0) shortest = min(shortest, lengths_[s]);
        if (s == sub) length = lengths_[s];
      }
      if (next < end)
        steps = max(shortest / kUnroll * kUnroll, rounded_up(longest - (kRing - kWarp)));
      rings_.pad(head_, length, steps);
      __syncwarp();
      if (kMaps || clamped_ > 0)
        drain<true>(steps, begin);
      else
        drain<false>(steps, begin);
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

  /// The sub-tiles with a pixel that has not stopped. The rings of the other sub-tiles are emptied.
  __device__ unsigned live_sub_tiles() {
    const unsigned lanes = __ballot_sync(kAllLanes, column_.any_live());
    unsigned live = 0;
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      if ((lanes >> (s * kLanes) & ((1u << kLanes) - 1)) != 0)
        live |= 1u << s;
      else
        lengths_[s] = 0;
    }
    return live;
  }

  /// Appends the Gaussian of this lane, list entry `entry`, to the rings that it reaches. Returns
  /// true if the alpha of an appended Gaussian may exceed kAlphaMax.
  __device__ bool fill(std::uint32_t entry, bool exists, std::uint32_t gaussian, unsigned live) {
    const BoundedSplat splat = in_.splats[gaussian];
    const float x0 = x_ - splat.x, y0 = y_ - splat.y, rows = splat.clamp_rows;
    const Reach reach(splat.ellipse, x0, y0);
    const bool clamps = exists && y0 <= rows && y0 + (kHalfTileHeight - 1) >= -rows;
    const Stage stage(splat, x0, y0, in_.background);
    if (kRows == Rows::products && __any_sync(kAllLanes, rows == INFINITY))
#pragma unroll
      for (unsigned s = 0; s < kSubTiles; ++s)
        exists = exists && (rows < INFINITY || !reach.reached[s] || stage.is_finite(s));
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      const bool mine = reach.reached[s] && exists && (live >> s & 1) != 0;
      const unsigned reaching = __ballot_sync(kAllLanes, mine);
      if (mine) {
        const unsigned place = lengths_[s] + __popc(reaching & lanes_below_);
        const unsigned slot = Rings<kMaps>::wrapped(head_ + place);
        rings_.rings[s].store(slot, stage.at(s));
        if constexpr (kMaps) rings_.places[s][slot] = entry;
      }
      lengths_[s] += __popc(reaching);
    }
    return __any_sync(kAllLanes, clamps);
  }

  /// A Gaussian about to be staged.
  struct Stage {
    const BoundedSplat& splat;
    float u[2], v[2];  // offset of the sub-tiles' middles, and of their first rows
    float along[2], down[2];
    float4 rest;
    float blue;

    __device__ Stage(const BoundedSplat& from, float x0, float y0, glm::vec3 background)
        : splat(from),
          u{x0 + 0.5f * (kSubWidth - 1), x0 + (kSubWidth + 0.5f * (kSubWidth - 1))},
          v{y0, y0 + kSubHeight},
          along{from.xx * u[0], from.xx * u[1]},
          down{from.yy * v[0], from.yy * v[1]},
          rest{from.xy, bend_of(from.yy + from.yy), from.red - background.x,
               from.green - background.y},
          blue(from.blue - background.z) {}

    __device__ Staged at(unsigned s) const {
      const unsigned column = s % 2, row = s / 2;
      const float slant = fmaf(splat.xy, v[row], along[column]);
      return {{fmaf(u[column], slant, fmaf(down[row], v[row], splat.log2_opacity)),
               fmaf(splat.xx, u[column], slant), splat.xx,
               fmaf(2.0f, down[row], fmaf(splat.xy, u[column], splat.yy))},
              rest,
              blue};
    }

    static __device__ float bend_of(float log2_bend) {
      return kRows == Rows::products ? exp2_flush(log2_bend) : log2_bend;
    }

    /// False if the products of a column could overflow. This happens only to a very thin Gaussian
    /// whose conic is broken by rounding; it is not drawn.
    __device__ bool is_finite(unsigned s) const {
      constexpr float kFar = 0.5f * (kSubWidth - 1), kMaxLog2 = 64.0f;
      const float4 shape = at(s).shape;
      return fmaf(kFar, fabsf(shape.y), shape.x) < kMaxLog2 &&
             fmaf(kFar, fabsf(rest.x), shape.w) < kMaxLog2;
    }
  };

  template <bool kClamps>
  __device__ void drain(unsigned steps, std::uint32_t begin) {
    const unsigned sub = lane_index() / kLanes;
    const Ring& ring = rings_.rings[sub];
    while (steps > 0) {
      const unsigned run = min(steps, kRing - head_);
#pragma unroll 1
      for (unsigned at = head_, last = head_ + run; at < last; at += kUnroll) {
#pragma unroll
        for (unsigned k = 0; k < kUnroll; ++k) {
          if constexpr (!kMaps) {
            column_.template add<kClamps, kRows>(ring.shape[at + k], ring.rest[at + k],
                                                 ring.blue[at + k], in_.most_log2_alpha);
          } else {
            const Column<kCut> before = column_;
            column_.template add<kClamps, kRows>(ring.shape[at + k], ring.rest[at + k],
                                                 ring.blue[at + k], in_.most_log2_alpha);
            mark(before, rings_.places[sub][at + k], begin);
          }
        }
      }
      head_ = Rings<kMaps>::wrapped(head_ + run);
      steps -= run;
    }
  }

  __device__ void mark(const Column<kCut>& before, std::uint32_t entry, std::uint32_t begin) {
    bool used = false;
    for (int j = 0; j < kPixels; ++j) {
      const ColumnPixel<kCut>&was = before.pixels[j], &is = column_.pixels[j];
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
  unsigned lanes_below_;
  unsigned head_ = 0, lengths_[kSubTiles] = {};
  unsigned clamped_ = 0;  // steps until all Gaussians with alphas above kAlphaMax are composited
};

// A few single pixels. The lanes take 32 list entries at a time and compute their alphas at one
// pixel after the other; then the entries that contribute to a pixel are composited in order. This
// is cheaper than a Walk for up to kFewPixels pixels of half a tile, because it does no work for
// the others.

inline constexpr unsigned kFewPixels = 4;

/// A pixel whose colour and transmittance are known up to an entry of the list.
struct WalkedPixel {
  float transmittance;  ///< 0 once it has stopped
  float red, green, blue;
};

/// All lanes of a warp call the functions together. `pixels` is the lane's column, which begins at
/// HalfTile::x and y.
class PixelWalk {
 public:
  __device__ PixelWalk(const ListInput& in, const HalfTile& half, WalkedPixel (&pixels)[kPixels])
      : in_(in), half_(half), pixels_(pixels) {
#pragma unroll
    for (int j = 0; j < kPixels; ++j)
      live_[j] = __ballot_sync(kAllLanes, pixels[j].transmittance > 0.0f);
  }

  __device__ unsigned count() const {
    unsigned sum = 0;
    for (const unsigned live : live_) sum += static_cast<unsigned>(__popc(live));
    return sum;
  }

  /// Composites the pairs [begin, end) onto the pixels with transmittance.
  __device__ void composite(std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t first = begin; first < end && count() > 0; first += kWarp) {
      const std::uint32_t entry = min(first + lane_index(), end - 1);
      const BoundedSplat splat = in_.splats[in_.gaussians[entry]];
      const bool exists = first + lane_index() < end;
#pragma unroll
      for (int j = 0; j < kPixels; ++j) {
        for (unsigned left = live_[j]; left != 0; left &= left - 1) {
          const unsigned owner = lowest_bit(left);
          if (!composite_onto(pixels_[j], owner, j, splat, exists)) live_[j] &= ~(1u << owner);
        }
      }
    }
  }

 private:
  /// Composites the lanes' splats, in order, onto a pixel of lane `owner`. Returns false if it has
  /// stopped.
  __device__ bool composite_onto(WalkedPixel& own, unsigned owner, int row,
                                 const BoundedSplat& splat, bool exists) {
    const auto x = static_cast<float>(__shfl_sync(kAllLanes, half_.x, owner));
    const auto y = static_cast<float>(__shfl_sync(kAllLanes, half_.y, owner) + row);
    const float alpha = exists ? alpha_at(splat, x, y) : 0.0f;
    unsigned left = __ballot_sync(kAllLanes, alpha >= kAlphaMin);
    if (left == 0) return true;
    WalkedPixel pixel{
        __shfl_sync(kAllLanes, own.transmittance, owner), __shfl_sync(kAllLanes, own.red, owner),
        __shfl_sync(kAllLanes, own.green, owner), __shfl_sync(kAllLanes, own.blue, owner)};
    for (; left != 0 && pixel.transmittance > 0.0f; left &= left - 1) {
      const unsigned from = lowest_bit(left);
      const float weight = __shfl_sync(kAllLanes, alpha, from) * pixel.transmittance;
      const float behind = pixel.transmittance - weight;
      const float red = __shfl_sync(kAllLanes, splat.red, from) - in_.background.x;
      const float green = __shfl_sync(kAllLanes, splat.green, from) - in_.background.y;
      const float blue = __shfl_sync(kAllLanes, splat.blue, from) - in_.background.z;
      if (behind < kTransmittanceMin) {
        pixel.transmittance = 0;
      } else {
        pixel = {behind, fmaf(weight, red, pixel.red), fmaf(weight, green, pixel.green),
                 fmaf(weight, blue, pixel.blue)};
      }
    }
    if (lane_index() == owner) own = pixel;
    return pixel.transmittance > 0.0f;
  }

  /// 0 if rounding broke the conic, as with Rows::exponents.
  __device__ float alpha_at(const BoundedSplat& splat, float x, float y) const {
    const float dx = x - splat.x, dy = y - splat.y;
    const float along = fmaf(splat.xy, dy, splat.xx * dx);
    const float log2_alpha = fmaf(dx, along, fmaf(splat.yy * dy, dy, splat.log2_opacity));
    return log2_alpha <= in_.most_log2_alpha ? fminf(exp2_flush(log2_alpha), kAlphaMax) : 0.0f;
  }

  const ListInput& in_;
  const HalfTile& half_;
  WalkedPixel (&pixels_)[kPixels];
  unsigned live_[kPixels];  // per row: the lanes whose pixel has not stopped
};

}  // namespace qs::cuda::fast
