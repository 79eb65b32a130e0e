// SPDX-License-Identifier: MIT
//
// A warp composites a range of a tile's list onto a few single pixels. The lanes take 32 list
// entries at a time and compute their alphas at one pixel after the other; then the entries that
// contribute to a pixel are composited in order. This is cheaper than walk.cuh for up to kFewPixels
// pixels of half a tile, because it does no work for the others.
#pragma once

#include "raster/cuda/fast/walk.cuh"

namespace qs::cuda::fast {

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
  static __device__ float alpha_at(const BoundedSplat& splat, float x, float y) {
    const float dx = x - splat.x, dy = y - splat.y;
    const float along = fmaf(splat.xy, dy, splat.xx * dx);
    const float log2_alpha = fmaf(dx, along, fmaf(splat.yy * dy, dy, splat.log2_opacity));
    return log2_alpha <= kLog2Slack ? fminf(exp2_flush(log2_alpha), kAlphaMax) : 0.0f;
  }

  const ListInput& in_;
  const HalfTile& half_;
  WalkedPixel (&pixels_)[kPixels];
  unsigned live_[kPixels];  // per row: the lanes whose pixel has not stopped
};

}  // namespace qs::cuda::fast
