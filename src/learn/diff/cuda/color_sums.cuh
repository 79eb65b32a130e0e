// SPDX-License-Identifier: MIT
//
// The backward pass of color_blend.cuh: every pair of a tile and a Gaussian gets its own sum over
// the tile's pixels. No sum depends on the order in which threads run, so two runs give the same
// bits.
//
// A block takes a segment of a tile's list, with one pixel per thread. It composites again, from
// the front to the back. A warp sums its pixels for a Gaussian by exchanges between lanes, and the
// block sums its warps in a fixed order. A list may have any length, because its segments do not
// wait for each other.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/segment.cuh"
#include "learn/diff/gaussians.h"
#include "learn/gradient/pixel.h"
#include "raster/cuda/common/flush.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/blend.h"

namespace qs::cuda::diff {

inline constexpr unsigned kWarps = kTilePixels / kWarp;
inline constexpr unsigned kSums = 9;  ///< numbers of PixelSums
/// Blocks of sum_pairs on a multiprocessor. With depths they need more registers.
inline constexpr unsigned kBlocksAtOnce = 6, kDeepBlocksAtOnce = 5;
static_assert(sizeof(PixelSums<float>) == kSums * sizeof(float));

/// Derivatives by the colours of the pixels, row by row, and the rules and colours of training. A
/// kernel parameter, as the next.
struct TrainedDerivatives {
  static constexpr bool kDepths = false;  ///< depths have derivatives
  const glm::vec3* values;

  __device__ qs::diff::Rows<const float> colors() const { return {}; }
  __device__ void limit(Contribution&) const {}
  __device__ bool passes(const Contribution&) const { return true; }
  __device__ glm::vec3 color(int, int, std::size_t at) const { return values[at]; }
  __device__ float of_transmittance(int, int, std::size_t) const { return 0; }
  __device__ const float* depths() const { return nullptr; }
};

/// Derivatives by the pictures of a caller. Each picture may be missing. `kDefault` as for
/// CallersView.
template <bool kDefault, bool kDepth>
struct CallersDerivatives {
  static constexpr bool kDepths = kDepth;
  PixelRules<float> rules;
  qs::diff::Rows<const float> channels;  ///< see CallersView
  Pictures<const float> by;
  const float* transmittance;  ///< transmittance of the pixels, row by row
  DepthArrays source;

  __device__ qs::diff::Rows<const float> colors() const { return channels; }
  __device__ void limit(Contribution& contribution) const {
    if constexpr (!kDefault) limit_alpha(rules, contribution);
  }
  /// False if alpha is clamped, and its gradient is 0 there.
  __device__ bool passes(const Contribution& contribution) const {
    return kDefault || rules.alpha_max_passes || contribution.unclamped < rules.alpha_max;
  }
  __device__ glm::vec3 color(int x, int y, std::size_t) const {
    if (!by.color) return glm::vec3(0.0f);
    return {by.color.at(x, y, 0), by.color.at(x, y, 1), by.color.at(x, y, 2)};
  }
  /// The transmittance behind the last Gaussian times the derivative by it.
  __device__ float of_transmittance(int x, int y, std::size_t at) const {
    return by.alpha ? -by.alpha.at(x, y) * transmittance[at] : 0.0f;
  }
  __device__ const float* depths() const { return source.z; }
  /// Derivatives by the sums of z and of 1 / z.
  __device__ glm::vec2 depth(int x, int y) const {
    return {by.depth ? by.depth.at(x, y) : 0.0f,
            by.inverse_depth ? by.inverse_depth.at(x, y) : 0.0f};
  }
  __device__ glm::vec2 depth_sums(std::size_t at) const {
    return {source.depth[at], source.inverse_depth[at]};
  }
};

/// A frame of blend_tiles(), and derivatives. A kernel parameter.
template <class Derivatives>
struct PairInput {
  TilesView tiles;
  const std::uint32_t* segment_tiles;
  const float4* states;
  const glm::vec3* color;
  const std::uint32_t* last;
  Derivatives by;

  PairInput(const ListedFrame& frame, const GpuPixelBlock& pixels, const Derivatives& derivatives)
      : tiles(frame.tiles()),
        segment_tiles(pixels.segment_tiles),
        states(pixels.states),
        color(pixels.colors()),
        last(pixels.last),
        by(derivatives) {}
};

/// Adds the value of the lane that differs in bit `kDistance`. Of two values, the lanes with the
/// bit get the second value.
template <unsigned kDistance>
__device__ float fold(float value) {
  return value + __shfl_xor_sync(kAllLanes, value, kDistance);
}
template <unsigned kDistance>
__device__ float fold(unsigned lane, float without, float with) {
  const bool bit = (lane & kDistance) != 0;
  const float sent = bit ? without : with, kept = bit ? with : without;
  return kept + __shfl_xor_sync(kAllLanes, sent, kDistance);
}

/// Sums of 16 lanes. Every exchange halves the numbers that a lane holds. All lanes call it; the
/// result is the sum of the number that number_of_lane() returns.
template <unsigned kDistance, unsigned kCount>
__device__ float sum_of_half(unsigned lane, const float (&values)[kCount]) {
  constexpr unsigned kHalf = (kCount + 1) / 2;
  float folded[kHalf];
#pragma unroll
  for (unsigned k = 0; k < kHalf; ++k)
    folded[k] = 2 * k + 1 < kCount
                    ? fold<kDistance>(lane, values[2 * k], values[(2 * k + 1) % kCount])
                    : fold<kDistance>(values[2 * k]);
  if constexpr (kDistance > 1)
    return sum_of_half<kDistance / 2>(lane, folded);
  else
    return folded[0];
}

/// The index of the sum that sum_of_half() returns to this lane.
template <unsigned kDistance, unsigned kCount>
__device__ unsigned number_of_lane(unsigned lane) {
  constexpr unsigned kHalf = (kCount + 1) / 2;
  unsigned half = 0;
  if constexpr (kDistance > 1)
    half = number_of_lane<kDistance / 2, kHalf>(lane);
  else
    static_assert(kHalf == 1);
  const bool second = (lane & kDistance) != 0 && 2 * half + 1 < kCount;
  return 2 * half + (second ? 1 : 0);
}

__device__ inline float dot(const glm::vec3& a, const glm::vec3& b) {
  return fmaf(a.x, b.x, fmaf(a.y, b.y, a.z * b.z));
}
__device__ inline float dot(const glm::vec2& a, const glm::vec2& b) {
  return fmaf(a.x, b.x, a.y * b.y);
}

/// The factors of the nine products that a pixel adds to the sums of a Gaussian.
struct PixelShare {
  float dx, dy;  ///< offset from the Gaussian's mean to the pixel
  float d;       ///< derivative by the logarithm of alpha
  float weight;  ///< weight of the Gaussian's colour in the pixel
  bool blends;

  __device__ void products(const glm::vec3& d_color, float* result) const {
    result[0] = d;
    result[1] = d * dx;
    result[2] = d * dy;
    result[3] = result[1] * dx;
    result[4] = result[1] * dy;
    result[5] = result[2] * dy;
    result[6] = weight * d_color.x;
    result[7] = weight * d_color.y;
    result[8] = weight * d_color.z;
  }
};

/// The absolute values of a pixel's part of the derivative by the mean, see add_pixel().
__device__ inline glm::vec2 absolute_of(const SharedSegment& segment, std::uint32_t entry,
                                        const PixelShare& share) {
  const float conic_x = segment.shapes[entry].z, conic_y = segment.shapes[entry].w,
              conic_z = segment.lights[entry].x;
  const float dx = share.d * share.dx, dy = share.d * share.dy;
  return static_cast<float>(kLn2) * glm::vec2(fabsf(fmaf(2 * conic_x, dx, conic_y * dy)),
                                              fabsf(fmaf(2 * conic_z, dy, conic_y * dx)));
}

/// The numbers that sum_pairs() sums for a pair: the numbers of PixelSums, then two each of the
/// absolute values and of the depths.
template <bool kAbsolute, bool kDepths>
struct PairNumbers {
  static constexpr bool kHasAbsolute = kAbsolute;
  static constexpr unsigned kDepth = kSums + (kAbsolute ? 2 : 0);  ///< the first of the depths
  static constexpr unsigned kCount = kDepth + (kDepths ? 2 : 0);
};

/// The pixel of a thread, composited again with the operations of the forward pass. So its values
/// do not depend on where segments begin, and all lossless modes give equal gradients.
template <bool kDepths>
struct SegmentPixel {
  float x, y;
  glm::vec3 d_color{0};
  glm::vec2 d_depth{0};   ///< derivative by the sums of z and 1 / z
  std::uint32_t end = 0;  ///< entries of the segment up to the last blended entry
  /// Product of dL/dC and the pixel's final colour, and of dL/dT and its transmittance behind the
  /// last Gaussian: both are products of (1 - alpha) of all Gaussians in front.
  float product = 0;
  glm::vec3 so_far{0};        ///< colour, without the background
  glm::vec2 depth_so_far{0};  ///< sums of z and 1 / z
  float transmittance = 1;

  /// `first` is the segment's first entry in the tile's list.
  template <class Derivatives>
  __device__ SegmentPixel(const PairInput<Derivatives>& in, std::uint32_t tile,
                          std::uint32_t first) {
    const int px = in.tiles.x_of(tile, threadIdx.x), py = in.tiles.y_of(tile, threadIdx.x);
    x = static_cast<float>(px);
    y = static_cast<float>(py);
    if (!in.tiles.contains(px, py)) return;
    const std::size_t at = in.tiles.index_of(px, py);
    end = max(in.last[at], first) - first;
    if (end == 0) return;
    d_color = in.by.color(px, py, at);
    const std::size_t state_at = std::size_t{blockIdx.x} * kTilePixels + threadIdx.x;
    const float4 state = in.states[state_at];
    product = dot(d_color, in.color[at]) + in.by.of_transmittance(px, py, at);
    so_far = {state.x, state.y, state.z};
    transmittance = state.w;
    if constexpr (kDepths) {
      d_depth = in.by.depth(px, py);
      product += dot(d_depth, in.by.depth_sums(at));
      depth_so_far = in.by.source.states[state_at];
    }
  }

  /// The pixel's share of the Gaussian's sums, see add_pixel() of the CPU. It is zero if the pixel
  /// does not blend the Gaussian. A pixel never stops below `end`.
  __device__ PixelShare add(const Contribution& by, const SharedDepths<kDepths>& depths,
                            std::uint32_t entry, bool exists, bool passes) {
    const bool blends = exists && by.counts;
    const float weight = by.alpha * transmittance;
    float by_values = fmaf(d_color.x, by.light.z, fmaf(d_color.y, by.light.w, d_color.z * by.blue));
    const glm::vec3 next(fmaf(weight, by.light.z, so_far.x), fmaf(weight, by.light.w, so_far.y),
                         fmaf(weight, by.blue, so_far.z));
    // The final colour of a pixel is known, so the colour behind is the difference to the colour so
    // far.
    float after = product - dot(d_color, next);
    glm::vec2 next_depth(0.0f);
    if constexpr (kDepths) {
      next_depth = sum_by_weight(depth_so_far, weight, depths, entry);
      by_values += dot(d_depth, depths.values[entry]);
      after -= dot(d_depth, next_depth);
    }
    const float d_alpha =
        fmaf(by_values, transmittance, -(after * reciprocal_flush(1.0f - by.alpha)));
    if (blends) {
      so_far = next;
      depth_so_far = next_depth;
      transmittance = by.behind(transmittance);
    }
    return {by.dx, by.dy, blends && passes ? by.unclamped * d_alpha : 0.0f, blends ? weight : 0.0f,
            blends};
  }
};

/// The pixel of the lane that differs in the highest bit: in the same column of the image.
struct OtherPixel {
  static constexpr unsigned kDistance = kWarp / 2;

  float y;
  glm::vec3 d_color;
  glm::vec2 d_depth{0};

  __device__ static float exchange(float value) {
    return __shfl_xor_sync(kAllLanes, value, kDistance);
  }
  template <bool kDepths>
  __device__ explicit OtherPixel(const SegmentPixel<kDepths>& own)
      : y(exchange(own.y)),
        d_color(exchange(own.d_color.x), exchange(own.d_color.y), exchange(own.d_color.z)) {
    if constexpr (kDepths) d_depth = {exchange(own.d_depth.x), exchange(own.d_depth.y)};
  }
};

/// The sums of a warp's pixels for two Gaussians. The lanes of each half first get their Gaussian:
/// of the pixel of another lane they need two factors, the other factors they know. All lanes call
/// it.
template <class Numbers, bool kDepths>
__device__ float sum_of_warp(unsigned lane, const SharedSegment& segment,
                             const PixelShare (&shares)[2], const std::uint32_t (&entries)[2],
                             const SegmentPixel<kDepths>& pixel, const OtherPixel& other) {
  const bool second = (lane & OtherPixel::kDistance) != 0;
  const float mean_y = second ? segment.shapes[entries[1]].y : segment.shapes[entries[0]].y;
  const PixelShare own{second ? shares[1].dx : shares[0].dx, second ? shares[1].dy : shares[0].dy,
                       second ? shares[1].d : shares[0].d,
                       second ? shares[1].weight : shares[0].weight, false};
  const PixelShare others{
      own.dx, other.y - mean_y, OtherPixel::exchange(second ? shares[0].d : shares[1].d),
      OtherPixel::exchange(second ? shares[0].weight : shares[1].weight), false};
  float sums[Numbers::kCount], more[Numbers::kCount];
  own.products(pixel.d_color, sums);
  others.products(other.d_color, more);
  if constexpr (kDepths) {
    sums[Numbers::kDepth] = own.weight * pixel.d_depth.x;
    sums[Numbers::kDepth + 1] = own.weight * pixel.d_depth.y;
    more[Numbers::kDepth] = others.weight * other.d_depth.x;
    more[Numbers::kDepth + 1] = others.weight * other.d_depth.y;
  }
  if constexpr (Numbers::kHasAbsolute) {
    const std::uint32_t entry = second ? entries[1] : entries[0];
    const glm::vec2 of_own = absolute_of(segment, entry, own),
                    of_others = absolute_of(segment, entry, others);
    sums[kSums] = of_own.x;
    sums[kSums + 1] = of_own.y;
    more[kSums] = of_others.x;
    more[kSums + 1] = of_others.y;
  }
#pragma unroll
  for (unsigned k = 0; k < Numbers::kCount; ++k) sums[k] += more[k];
  return sum_of_half<OtherPixel::kDistance / 2>(lane, sums);
}

struct PairSums {
  PixelSums<float>* pairs;
  glm::vec2* absolute;  ///< if kAbsolute
  /// Sums of the weight times the derivatives by the sums of z and 1 / z, if any.
  glm::vec2* depths;
};

/// One block per segment. While some warps add up the sums of a group, others begin the next group.
template <bool kAbsolute, class Derivatives>
__global__ void __launch_bounds__(
    kTilePixels, blocks_at_once(Derivatives::kDepths ? kDeepBlocksAtOnce : kBlocksAtOnce,
                                kTilePixels)) sum_pairs(PairInput<Derivatives> in, PairSums out) {
  using Numbers = PairNumbers<kAbsolute, Derivatives::kDepths>;
  constexpr unsigned kNumbers = Numbers::kCount;
  __shared__ SharedSegment segment;
  __shared__ SharedDepths<Derivatives::kDepths> depths;
  __shared__ float sums_of_warps[2][kWarps][kWarp * kNumbers];
  __shared__ std::uint32_t ends[kWarps];
  const std::uint32_t tile = in.segment_tiles[blockIdx.x];
  if (tile == kNoTile) return;
  const unsigned warp = threadIdx.x / kWarp, lane = kept(lane_index());
  const uint2 range = in.tiles.ranges[tile];
  const std::uint32_t first = (blockIdx.x - first_segment(range.x, tile)) * kSegment;
  const std::uint32_t size = min(range.y - range.x - first, kSegment);
  segment.load(in.tiles, tile, range.x + first, size, in.by.colors());
  depths.load(in.tiles, in.by.depths(), range.x + first, size);
  SegmentPixel<Derivatives::kDepths> pixel(in, tile, first);
  const OtherPixel other(pixel);
  const std::uint32_t end_of_warp = min(size, largest_of_warp(pixel.end));
  if (lane == 0) ends[warp] = end_of_warp;
  __syncthreads();
  const std::uint32_t end = largest_of_warp(ends[lane % kWarps]);
  const unsigned number = kept(number_of_lane<kWarp / 4, kNumbers>(lane));
  for (std::uint32_t group = 0; group < size; group += kWarp) {
    auto& sums = sums_of_warps[group / kWarp % 2];
    if (group < end) {
      float* const own = sums[warp];
      for (unsigned k = 0; k < kNumbers; ++k) own[k * kWarp + lane] = 0;
      __syncwarp();
      unsigned reaching = segment.reaching(group, end_of_warp);
      while (reaching != 0) {
        const unsigned member = lowest_bit(reaching);
        reaching &= reaching - 1;
        const bool pairs = reaching != 0;
        const unsigned next = pairs ? lowest_bit(reaching) : member;
        reaching &= reaching - 1;
        const std::uint32_t entries[] = {group + member, group + next};
        Contribution by[] = {segment.contribution(entries[0], pixel.x, pixel.y),
                             segment.contribution(entries[1], pixel.x, pixel.y)};
        in.by.limit(by[0]);
        in.by.limit(by[1]);
        const PixelShare shares[] = {
            pixel.add(by[0], depths, entries[0], entries[0] < pixel.end, in.by.passes(by[0])),
            pixel.add(by[1], depths, entries[1], pairs && entries[1] < pixel.end,
                      in.by.passes(by[1]))};
        if (!__any_sync(kAllLanes, shares[0].blends || shares[1].blends)) continue;
        const float sum = sum_of_warp<Numbers>(lane, segment, shares, entries, pixel, other);
        const bool second = lane >= kWarp / 2;
        if (pairs || !second) own[(second ? next : member) * kNumbers + number] = sum;
      }
      __syncthreads();
    }
    for (unsigned k = threadIdx.x; k < kWarp * kNumbers; k += kTilePixels) {
      const std::uint32_t entry = group + k / kNumbers;
      if (entry >= size) break;
      float sum = 0;
      if (group < end)
        for (unsigned each = 0; each < kWarps; ++each) sum += sums[each][k];
      const std::uint32_t place = in.tiles.places[range.x + first + entry];
      const unsigned which = k % kNumbers;
      if (which < kSums)
        reinterpret_cast<float*>(out.pairs + place)[which] = sum;
      else if (kAbsolute && which < kSums + 2)
        reinterpret_cast<float*>(out.absolute + place)[which - kSums] = sum;
      else
        reinterpret_cast<float*>(out.depths + place)[which - Numbers::kDepth] = sum;
    }
  }
}

}  // namespace qs::cuda::diff
