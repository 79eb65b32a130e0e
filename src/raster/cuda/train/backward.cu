// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/stages/segment.cuh"
#include "raster/cuda/stages/sum_gaussians.cuh"
#include "raster/cuda/train/backward.cuh"
#include "raster/kernel/gradient/color_field.h"

namespace qs::cuda::train {
namespace {

using stages::Contribution;
using stages::lowest_bit;
using stages::SharedSegment;

constexpr unsigned kWarps = kTilePixels / kWarp;
constexpr unsigned kSums = 9;          // numbers of PixelSums
constexpr unsigned kBlocksAtOnce = 6;  // of sum_pairs on a multiprocessor
static_assert(sizeof(PixelSums<float>) == kSums * sizeof(float));

struct PairInput {
  TilesView tiles;
  const std::uint32_t* segment_tiles;
  const float4* states;
  const glm::vec3* color;
  const std::uint32_t* last;
  const glm::vec3* d_color;
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
  for (unsigned k = 0; k < kHalf; ++k) {
    folded[k] = 2 * k + 1 < kCount
                    ? fold<kDistance>(lane, values[2 * k], values[(2 * k + 1) % kCount])
                    : fold<kDistance>(values[2 * k]);
  }
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

__device__ float dot(const glm::vec3& a, const glm::vec3& b) {
  return fmaf(a.x, b.x, fmaf(a.y, b.y, a.z * b.z));
}

/// The factors of the nine products that a pixel adds to the sums of a Gaussian.
struct PixelShare {
  float dx, dy;  ///< from the Gaussian's mean to the pixel
  float d;       ///< by the logarithm of alpha
  float weight;  ///< of the Gaussian's colour in the pixel
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
__device__ glm::vec2 absolute_of(const SharedSegment& segment, std::uint32_t entry,
                                 const PixelShare& share) {
  const float conic_x = segment.shapes[entry].z, conic_y = segment.shapes[entry].w,
              conic_z = segment.lights[entry].x;
  const float dx = share.d * share.dx, dy = share.d * share.dy;
  return static_cast<float>(kLn2) * glm::vec2(fabsf(fmaf(2 * conic_x, dx, conic_y * dy)),
                                              fabsf(fmaf(2 * conic_z, dy, conic_y * dx)));
}

/// The pixel of a thread, composited again with the operations of the forward pass. So its values
/// do not depend on where segments begin, and all lossless modes give equal gradients.
struct SegmentPixel {
  float x, y;
  glm::vec3 d_color{0};
  std::uint32_t end = 0;  ///< entries of the segment up to the last blended entry
  float product = 0;      ///< of dL/dC and the pixel's final colour
  glm::vec3 so_far{0};    ///< colour, without the background
  float transmittance = 1;

  /// `first` is the segment's first entry in the tile's list.
  __device__ SegmentPixel(const PairInput& in, std::uint32_t tile, std::uint32_t first) {
    const int px = in.tiles.x_of(tile, threadIdx.x), py = in.tiles.y_of(tile, threadIdx.x);
    x = static_cast<float>(px);
    y = static_cast<float>(py);
    if (!in.tiles.contains(px, py)) return;
    const std::size_t at = in.tiles.index_of(px, py);
    end = max(in.last[at], first) - first;
    if (end == 0) return;
    d_color = in.d_color[at];
    const float4 state = in.states[std::size_t{blockIdx.x} * kTilePixels + threadIdx.x];
    product = dot(d_color, in.color[at]);
    so_far = {state.x, state.y, state.z};
    transmittance = state.w;
  }

  /// The pixel's share of the Gaussian's sums, see add_pixel() of the CPU. It is zero if the pixel
  /// does not blend the Gaussian. A pixel never stops below `end`.
  __device__ PixelShare add(const Contribution& by, bool exists) {
    const bool blends = exists && by.counts;
    const float weight = by.alpha * transmittance;
    const float by_color =
        fmaf(d_color.x, by.light.z, fmaf(d_color.y, by.light.w, d_color.z * by.blue));
    const glm::vec3 next(fmaf(weight, by.light.z, so_far.x), fmaf(weight, by.light.w, so_far.y),
                         fmaf(weight, by.blue, so_far.z));
    // The final colour of a pixel is known, so the colour behind is the difference to the colour so
    // far.
    const float after = product - dot(d_color, next);
    const float d_alpha =
        fmaf(by_color, transmittance, -(after * reciprocal_flush(1.0f - by.alpha)));
    if (blends) {
      so_far = next;
      transmittance = by.behind(transmittance);
    }
    return {by.dx, by.dy, blends ? by.unclamped * d_alpha : 0.0f, blends ? weight : 0.0f, blends};
  }
};

/// The pixel of the lane that differs in the highest bit: in the same column of the image.
struct OtherPixel {
  static constexpr unsigned kDistance = kWarp / 2;

  float y;
  glm::vec3 d_color;

  __device__ static float exchange(float value) {
    return __shfl_xor_sync(kAllLanes, value, kDistance);
  }
  __device__ explicit OtherPixel(const SegmentPixel& own)
      : y(exchange(own.y)),
        d_color(exchange(own.d_color.x), exchange(own.d_color.y), exchange(own.d_color.z)) {}
};

/// The sums of a warp's pixels for two Gaussians. The lanes of each half first get their Gaussian:
/// of the pixel of another lane they need two factors, the other factors they know. All lanes call
/// it.
template <unsigned kNumbers>
__device__ float sum_of_warp(unsigned lane, const SharedSegment& segment,
                             const PixelShare (&shares)[2], const std::uint32_t (&entries)[2],
                             const SegmentPixel& pixel, const OtherPixel& other) {
  const bool second = (lane & OtherPixel::kDistance) != 0;
  const float mean_y = second ? segment.shapes[entries[1]].y : segment.shapes[entries[0]].y;
  const PixelShare own{second ? shares[1].dx : shares[0].dx, second ? shares[1].dy : shares[0].dy,
                       second ? shares[1].d : shares[0].d,
                       second ? shares[1].weight : shares[0].weight, false};
  const PixelShare others{
      own.dx, other.y - mean_y, OtherPixel::exchange(second ? shares[0].d : shares[1].d),
      OtherPixel::exchange(second ? shares[0].weight : shares[1].weight), false};
  float sums[kNumbers], more[kNumbers];
  own.products(pixel.d_color, sums);
  others.products(other.d_color, more);
  if constexpr (kNumbers > kSums) {
    const std::uint32_t entry = second ? entries[1] : entries[0];
    const glm::vec2 of_own = absolute_of(segment, entry, own),
                    of_others = absolute_of(segment, entry, others);
    sums[kSums] = of_own.x;
    sums[kSums + 1] = of_own.y;
    more[kSums] = of_others.x;
    more[kSums + 1] = of_others.y;
  }
#pragma unroll
  for (unsigned k = 0; k < kNumbers; ++k) sums[k] += more[k];
  return sum_of_half<OtherPixel::kDistance / 2>(lane, sums);
}

struct PairSums {
  PixelSums<float>* pairs;
  glm::vec2* absolute;  ///< if kAbsolute
};

/// One block per segment. While some warps add up the sums of a group, others begin the next group.
template <bool kAbsolute>
__global__ void __launch_bounds__(kTilePixels, kBlocksAtOnce)
    sum_pairs(PairInput in, PairSums out) {
  constexpr unsigned kNumbers = kSums + (kAbsolute ? 2 : 0);  // per pair
  __shared__ SharedSegment segment;
  __shared__ float sums_of_warps[2][kWarps][kWarp * kNumbers];
  __shared__ std::uint32_t ends[kWarps];
  const std::uint32_t tile = in.segment_tiles[blockIdx.x];
  if (tile == kNoTile) return;
  const unsigned warp = threadIdx.x / kWarp, lane = kept(lane_index());
  const uint2 range = in.tiles.ranges[tile];
  const std::uint32_t first = (blockIdx.x - first_segment(range.x, tile)) * kSegment;
  const std::uint32_t size = min(range.y - range.x - first, kSegment);
  segment.load(in.tiles, tile, range.x + first, size);
  SegmentPixel pixel(in, tile, first);
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
        const Contribution by[] = {segment.contribution(entries[0], pixel.x, pixel.y),
                                   segment.contribution(entries[1], pixel.x, pixel.y)};
        const PixelShare shares[] = {pixel.add(by[0], entries[0] < pixel.end),
                                     pixel.add(by[1], pairs && entries[1] < pixel.end)};
        if (!__any_sync(kAllLanes, shares[0].blends || shares[1].blends)) continue;
        const float sum = sum_of_warp<kNumbers>(lane, segment, shares, entries, pixel, other);
        const bool second = lane >= kWarp / 2;
        if (pairs || !second) own[(second ? next : member) * kNumbers + number] = sum;
      }
      __syncthreads();
    }
    for (unsigned k = threadIdx.x; k < kWarp * kNumbers; k += kTilePixels) {
      const std::uint32_t entry = group + k / kNumbers;
      if (entry >= size) break;
      float sum = 0;
      if (group < end) {
        for (unsigned each = 0; each < kWarps; ++each) sum += sums[each][k];
      }
      const std::uint32_t place = in.tiles.places[range.x + first + entry];
      const unsigned which = k % kNumbers;
      if (which < kSums)
        reinterpret_cast<float*>(out.pairs + place)[which] = sum;
      else
        reinterpret_cast<float*>(out.absolute + place)[which - kSums] = sum;
    }
  }
}

template <unsigned kNumbers>
void launch_sums(const StepView& view, std::uint32_t count, const ForwardFrame& frame,
                 const void* pairs, void* sums) {
  stages::sum_pairs_of_gaussians<kNumbers>(
      {count, frame.first_places.data(), frame.tile_counts.data(), static_cast<const float*>(pairs),
       static_cast<float*>(sums)},
      view.stream);
}

struct GaussianInput {
  GradientRules<float> rules;
  ParametersView parameters;
  const std::uint32_t* tile_counts;  ///< 0: not visible
  const PixelSums<float>* sums;      ///< per Gaussian
  const ListedSplat* splats;
};

/// One thread per Gaussian. `d_outputs` is null without a colour field.
__global__ void __launch_bounds__(kThreads)
    gaussian_gradients(GaussianInput in, ParametersView out, ColorGradient<float>* colors,
                       glm::vec2* d_mean_px, glm::vec3* d_outputs) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= in.parameters.count) return;
  GaussianValues<float> gradient{glm::vec3(0.0f), glm::vec3(0.0f), glm::quat(0, 0, 0, 0), 0.0f,
                                 0.0f};
  glm::vec2 mean_px(0.0f);
  ColorGradient<float> color{glm::vec3(0.0f), glm::vec3(0.0f)};
  glm::vec3 d_output(0.0f);
  if (in.tile_counts[i] > 0) {
    SplatGradient<float> splat = splat_gradient<float>(in.splats[i].splat, in.sums[i]);
    if (d_outputs != nullptr) {
      d_output = output_gradient(in.splats[i].splat.color, splat.color);
      splat.color = glm::vec3(0.0f);
    }
    const GaussianValues<float> gaussian = in.parameters.gaussian(i);
    const auto coefficient = [&](int k) { return in.parameters.coefficient(i, k); };
    color = ColorGradient<float>::of(in.rules, gaussian.mean, coefficient, splat.color);
    gradient = gaussian_gradient<float>(in.rules, gaussian, coefficient, splat, color,
                                        [](int, const glm::vec3&) {});
    mean_px = splat.mean_px;
  }
  out.set_gaussian(i, gradient);
  colors[i] = color;
  d_mean_px[i] = mean_px;
  if (d_outputs != nullptr) d_outputs[i] = d_output;
}

/// One thread per Gaussian.
__global__ void __launch_bounds__(kThreads)
    expand_color_gradients(int sh_degree, const ColorGradient<float>* colors, ParametersView out) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= out.count) return;
  for (int k = 0; k < out.sh_coefficients; ++k) out.set_coefficient(i, k, glm::vec3(0.0f));
  sh_gradient<float>(
      sh_degree, colors[i].direction, [](int) { return glm::vec3(0.0f); }, colors[i].by_color,
      [&](int k, const glm::vec3& by) { out.set_coefficient(i, k, by); });
}

void sum_pairs_of_tiles(const StepView& view, const ForwardFrame& frame, const glm::vec3* d_color,
                        bool absolute, BackwardScratch& scratch) {
  if (frame.pairs.count == 0) return;
  scratch.pairs.reserve("the step's pairs", frame.pairs.room());
  if (absolute) scratch.absolute.reserve("the step's pairs", frame.pairs.room());
  launch("sum_pairs", absolute ? sum_pairs<true> : sum_pairs<false>,
         Blocks(frame.segments, kTilePixels), view.stream,
         PairInput{frame.tiles(view), frame.segment_tiles.data(), frame.states.data(),
                   frame.color.data(), frame.last.data(), d_color},
         PairSums{scratch.pairs.data(), scratch.absolute.data()});
}

}  // namespace

void backward(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
              const glm::vec3* d_color, const qs::train::BackwardOrder& order,
              BackwardScratch& scratch, Gradients& gradients, glm::vec3* d_outputs) {
  gradients.by.resize_shapes(parameters.count, parameters.has_masks());
  gradients.colors.reserve("the gradients", with_room(parameters.count));
  gradients.mean_px.reserve("the gradients", with_room(parameters.count));
  gradients.has_absolute = order.absolute;
  if (order.absolute) gradients.absolute_px.reserve("the gradients", with_room(parameters.count));
  scratch.sums.reserve("the gradients", with_room(parameters.count));
  if (parameters.count == 0) return;
  view.throw_if_cancelled();
  sum_pairs_of_tiles(view, frame, d_color, order.absolute, scratch);
  gradients.sh_degree = std::min(view.settings.sh_degree, parameters.sh_degree);
  const GradientRules<float> rules{make_view<float>(view.camera), view.settings.dilation,
                                   view.antialiased(), gradients.sh_degree};
  const GaussianInput in{rules, parameters, frame.tile_counts.data(), scratch.sums.data(),
                         frame.splats.data()};
  launch_sums<kSums>(view, parameters.count, frame, scratch.pairs.data(), scratch.sums.data());
  if (order.absolute) {
    launch_sums<2>(view, parameters.count, frame, scratch.absolute.data(),
                   gradients.absolute_px.data());
  }
  launch("gaussian_gradients", gaussian_gradients, blocks_for(parameters.count), view.stream, in,
         gradients.by.view(), gradients.colors.data(), gradients.mean_px.data(), d_outputs);
}

void expand_colors(int sh_degree, cudaStream_t stream, Gradients& gradients) {
  gradients.by.resize(gradients.by.count, sh_degree, gradients.by.has_masks);
  if (gradients.by.count == 0) return;
  launch("expand_colors", expand_color_gradients, blocks_for(gradients.by.count), stream,
         gradients.sh_degree, gradients.colors.data(), gradients.by.view());
}

}  // namespace qs::cuda::train
