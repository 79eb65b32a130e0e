// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/blend.h"
#include "learn/diff/cuda/color_sums.cuh"
#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/sums.cuh"
#include "learn/diff/flags.h"
#include "learn/gradient/pixel.h"

namespace qs::cuda::diff {
namespace {

constexpr unsigned kShape = 7;       ///< numbers of PixelSums without its colour, and d/dz
constexpr unsigned kAbsolute = 2;    ///< absolute gradients
constexpr std::uint32_t kGroup = 8;  ///< entries that the warps sum before the block adds them up

unsigned size_of_channels(std::uint32_t channels) {
  return with_channels(static_cast<int>(channels),
                       [](auto size) { return static_cast<unsigned>(size()); });
}

/// Scratch memory of blend_backward().
struct SumScratch {
  // Per place.
  float *shapes, *absolute, *channels;
  // Per Gaussian.
  float *shape_sums, *absolute_sums, *channel_sums;
  double* rows;  ///< derivative by the background: a number per channel and row of pixels

  static SumScratch of(BlockArrays& block, const GpuHeldSizes& sizes) {
    const std::size_t pairs = sizes.pairs, gaussians = sizes.gaussians,
                      channels = size_of_channels(sizes.channels);
    SumScratch result{};
    result.shapes = block.next<float>(pairs * kShape);
    result.absolute = block.next<float>(pairs * kAbsolute);
    result.channels = block.next<float>(pairs * channels);
    result.shape_sums = block.next<float>(gaussians * kShape);
    result.absolute_sums = block.next<float>(gaussians * kAbsolute);
    result.channel_sums = block.next<float>(gaussians * channels);
    result.rows = block.next<double>(static_cast<std::size_t>(sizes.height) * channels);
    return result;
  }
};

/// A kernel parameter.
struct SumsInput {
  ChannelInput in;
  GpuPixelBlock state;
  Pictures<const float> by;

  /// True if there are derivatives by other pictures than the colour.
  __device__ bool is_deep() const { return by.alpha || by.depth || by.inverse_depth; }
};

/// The pixel of a thread while its tile is composited again. The derivative by a Gaussian's alpha
/// needs of the colours behind it only their product with the derivative by the pixel, so the
/// pixel holds that product.
template <int kChannels>
struct BackwardPixel {
  float x = 0, y = 0;
  std::uint32_t end = 0;  ///< entries up to the last blended entry
  float transmittance = 1;
  Color<float, kChannels> d_color{0};
  float to_come = 0;  ///< product of d_color and the colour behind, with the background
  float d_alpha = 0, d_depth = 0, d_inverse = 0;
  float last_transmittance = 0, depth_to_come = 0, inverse_to_come = 0;

  __device__ BackwardPixel(const SumsInput& sums, std::uint32_t tile) {
    const ChannelInput& in = sums.in;
    const int px = in.tiles.x_of(tile, threadIdx.x), py = in.tiles.y_of(tile, threadIdx.x);
    x = static_cast<float>(px);
    y = static_cast<float>(py);
    if (!in.tiles.contains(px, py)) return;
    const std::size_t at = in.tiles.index_of(px, py);
    end = sums.state.last[at];
#pragma unroll
    for (int c = 0; c < kChannels; ++c) {
      if (c >= in.channel_count || !sums.by.color) continue;
      d_color[c] = sums.by.color.at(px, py, c);
      to_come = fmaf(
          d_color[c],
          sums.state
              .color[at * static_cast<std::size_t>(in.channel_count) + static_cast<std::size_t>(c)],
          to_come);
    }
    last_transmittance = sums.state.transmittance[at];
    if (sums.state.depth != nullptr) {
      depth_to_come = sums.state.depth[at];
      inverse_to_come = sums.state.inverse_depth[at];
    }
    if (sums.by.alpha) d_alpha = sums.by.alpha.at(px, py);
    if (sums.by.depth) d_depth = sums.by.depth.at(px, py);
    if (sums.by.inverse_depth) d_inverse = sums.by.inverse_depth.at(px, py);
  }

  /// Blends a Gaussian. Returns its weight; `by_alpha` is dL/dalpha, `by_z` dL/dz.
  __device__ float blend(const SumsInput& sums, std::uint32_t gaussian, const Contribution& by,
                         float& by_alpha, float& by_z) {
    const ChannelInput& in = sums.in;
    const float weight = by.alpha * transmittance;
    float by_color = 0;
#pragma unroll
    for (int c = 0; c < kChannels; ++c)
      if (c < in.channel_count) by_color = fmaf(d_color[c], in.channel(gaussian, c), by_color);
    to_come = fmaf(-weight, by_color, to_come);
    const float rest = 1 - by.alpha;
    by_alpha = by_color * transmittance - to_come / rest;
    by_z = 0;
    if (sums.is_deep()) {
      const float z = in.depths[gaussian];
      depth_to_come -= weight * z;
      inverse_to_come -= weight / z;
      by_z = weight * (d_depth - d_inverse / (z * z));
      by_alpha += d_alpha * (last_transmittance / rest) +
                  d_depth * (z * transmittance - depth_to_come / rest) +
                  d_inverse * (transmittance / z - inverse_to_come / rest);
    }
    transmittance = by.behind(transmittance);
    return weight;
  }
};

/// The sum of the lanes, in all of them. All lanes call it.
__device__ float sum_of_lanes(float value) {
  for (unsigned distance = kWarp / 2; distance > 0; distance /= 2)
    value += __shfl_xor_sync(kAllLanes, value, distance);
  return value;
}

/// One block per tile. It composites the tile again, from the front to the back.
template <int kChannels>
__global__ void __launch_bounds__(kThreads) sum_channels(SumsInput sums, SumScratch out) {
  constexpr unsigned kNumbers = kShape + kAbsolute + kChannels;  // per pair
  __shared__ SharedSegment segment;
  __shared__ std::uint32_t owners[kSegment];
  __shared__ float of_warps[kWarps][kGroup][kNumbers];
  const ChannelInput& in = sums.in;
  const std::uint32_t tile = in.schedule.tile(blockIdx.x);
  const unsigned thread = threadIdx.x, warp = thread / kWarp, lane = lane_index();
  const uint2 range = in.tiles.ranges[tile];
  BackwardPixel<kChannels> pixel(sums, tile);
  const std::uint32_t end_of_warp = largest_of_warp(pixel.end);

  for (std::uint32_t first = range.x; first < range.y; first += kSegment) {
    const std::uint32_t size = min(range.y - first, kSegment), before = first - range.x;
    __syncthreads();  // the last segment may be in use
    segment.load(in.tiles, tile, first, size);
    if (thread < size) owners[thread] = in.tiles.owners[in.tiles.places[first + thread]];
    __syncthreads();
    for (std::uint32_t group = 0; group < size; group += kGroup) {
      for (std::uint32_t k = 0; k < kGroup && group + k < size; ++k) {
        const std::uint32_t entry = group + k;
        float* const own = of_warps[warp][k];
        for (unsigned n = lane; n < kNumbers; n += kWarp) own[n] = 0;
        __syncwarp();
        if (before + entry >= end_of_warp || (segment.warps[entry] >> warp & 1) == 0) continue;
        Contribution by = segment.contribution(entry, pixel.x, pixel.y);
        limit_alpha(in.rules, by);
        const bool counts = by.counts && before + entry < pixel.end;
        if (!__any_sync(kAllLanes, counts)) continue;
        float weight = 0, by_alpha = 0, by_z = 0;
        if (counts) weight = pixel.blend(sums, owners[entry], by, by_alpha, by_z);
        const bool passes = by.unclamped < in.rules.alpha_max || in.rules.alpha_max_passes;
        const float d = counts && passes ? by.unclamped * by_alpha : 0.0f;
        const float dx = counts ? by.dx : 0.0f, dy = counts ? by.dy : 0.0f;
        const float4 shape = segment.shapes[entry];
        const float conic_z = segment.lights[entry].x;
        const float numbers[kShape + kAbsolute] = {
            d,
            d * dx,
            d * dy,
            d * dx * dx,
            d * dx * dy,
            d * dy * dy,
            by_z,
            static_cast<float>(kLn2) * fabsf(fmaf(2 * shape.z, d * dx, shape.w * (d * dy))),
            static_cast<float>(kLn2) * fabsf(fmaf(2 * conic_z, d * dy, shape.w * (d * dx)))};
#pragma unroll
        for (unsigned n = 0; n < kShape + kAbsolute; ++n) {
          const float sum = sum_of_lanes(numbers[n]);
          if (lane == 0) own[n] = sum;
        }
#pragma unroll
        for (int c = 0; c < kChannels; ++c) {
          const float sum = sum_of_lanes(weight * pixel.d_color[c]);
          if (lane == 0) own[kShape + kAbsolute + static_cast<unsigned>(c)] = sum;
        }
      }
      __syncthreads();
      for (unsigned at = thread; at < kGroup * kNumbers; at += kThreads) {
        const unsigned k = at / kNumbers, n = at % kNumbers;
        if (group + k >= size) break;
        float sum = 0;
        for (unsigned w = 0; w < kWarps; ++w) sum += of_warps[w][k][n];
        const std::size_t place = in.tiles.places[first + group + k];
        if (n < kShape)
          out.shapes[place * kShape + n] = sum;
        else if (n < kShape + kAbsolute)
          out.absolute[place * kAbsolute + n - kShape] = sum;
        else
          out.channels[place * kChannels + n - kShape - kAbsolute] = sum;
      }
      __syncthreads();
    }
  }
}

/// Scratch memory of blend_backward() with states.
struct ColorScratch {
  PixelSums<float>*pairs, *sums;        ///< per place, per Gaussian
  glm::vec2 *absolute, *absolute_sums;  ///< the same
  glm::vec2 *depths, *depth_sums;       ///< the same, see PairSums; null without depths
  double* rows;                         ///< see SumScratch

  static ColorScratch of(BlockArrays& block, const GpuHeldSizes& sizes) {
    ColorScratch result{};
    result.pairs = block.next<PixelSums<float>>(sizes.pairs);
    result.absolute = block.next<glm::vec2>(sizes.pairs);
    result.sums = block.next<PixelSums<float>>(sizes.gaussians);
    result.absolute_sums = block.next<glm::vec2>(sizes.gaussians);
    if (sizes.has_depth) {
      result.depths = block.next<glm::vec2>(sizes.pairs);
      result.depth_sums = block.next<glm::vec2>(sizes.gaussians);
    }
    result.rows = block.next<double>(static_cast<std::size_t>(sizes.height) * sizes.channels);
    return result;
  }
};

/// The derivatives of a Gaussian, all 0 unless a tile lists it.
struct ListedGradient {
  SplatGradient<float> splat;
  float depth = 0;
  glm::vec2 absolute{0.0f};

  /// Writes the Gaussian's rows of the boundary, but for its colour.
  __device__ void write(std::uint32_t i, int channel_count,
                        const BoundaryGradients<float>& out) const {
    out.by.mean_px.set(i, splat.mean_px);
    out.by.conic.set(i, splat.conic);
    out.by.depth.set(i, depth);
    out.by.opacity.set(i, splat.opacity);
    out.by.color.fill(i, 3, 0);
    out.channels.fill(i, channel_count, 0);
    out.absolute_px.set(i, absolute);
  }
};

/// The derivative by a channel of the background, for a row of pixels: the transmittance behind the
/// last Gaussian is its weight. One block per row.
__global__ void __launch_bounds__(kThreads)
    background_of_rows(const float* transmittance, int width, int channel_count,
                       qs::diff::Pixels<const float> by, double* rows) {
  const int y = static_cast<int>(blockIdx.x);
  for (int c = 0; c < channel_count; ++c) {
    double own = 0;
    for (int x = static_cast<int>(threadIdx.x); x < width && by; x += int{kThreads})
      own += static_cast<double>(transmittance[std::size_t{blockIdx.x} * width + x]) *
             static_cast<double>(by.at(x, y, c));
    const double sum = sum_of_block<kThreads>(own).total;
    if (threadIdx.x == 0) rows[blockIdx.x * channel_count + c] = sum;
  }
}

void add_background(const GpuHeldSizes& sizes, const GpuPixelBlock& state,
                    const Pictures<const float>& by, double* rows, float* background,
                    cudaStream_t stream) {
  if (background == nullptr) return;
  const auto height = static_cast<unsigned>(sizes.height);
  launch("background", background_of_rows, height, stream, state.transmittance, sizes.width,
         static_cast<int>(sizes.channels), by.color, rows);
  launch("background", add_rows<float>, 1, stream, rows, height, sizes.channels, background);
}

void color_backward(const BlendInput& in, const ListedFrame& listed, const GpuPixelBlock& state,
                    const Pictures<const float>& by, const ColorScratch& scratch,
                    const BoundaryGradients<float>& out, cudaStream_t stream) {
  const GpuHeldSizes& sizes = listed.sizes;
  const bool absolute = static_cast<bool>(out.absolute_px);
  // Without derivatives by depths the kernels for colours do.
  const bool is_deep = by.depth || by.inverse_depth;
  const auto sum_with = [&](auto is_absolute, auto is_default, auto has_depth) {
    using Derivatives = CallersDerivatives<is_default(), has_depth()>;
    launch(
        "sum_pairs", sum_pairs<is_absolute(), Derivatives>,
        segments_of(sizes.pairs, tiles_of(sizes)), stream,
        PairInput<Derivatives>(
            listed, state, {in.rules, in.channels, by, state.transmittance, listed.depths(state)}),
        PairSums{scratch.pairs, scratch.absolute, scratch.depths});
  };
  if (sizes.pairs > 0) qs::diff::with_flags(sum_with, absolute, in.rules.are_default(), is_deep);
  const GpuGaussianBlock& gaussians = listed.gaussians;
  const std::uint32_t count = sizes.gaussians;
  sum_pairs_of_gaussians<kSums>(gaussians, count, scratch.pairs, scratch.sums, stream);
  if (absolute)
    sum_pairs_of_gaussians<kAbsolute>(gaussians, count, scratch.absolute, scratch.absolute_sums,
                                      stream);
  if (is_deep)
    sum_pairs_of_gaussians<2>(gaussians, count, scratch.depths, scratch.depth_sums, stream);
  else if (sizes.has_depth)
    set_zero("sums of depths", scratch.depth_sums, sizes.gaussians, stream);
  const Boundary<float>& rows = out.by;
  if (!rows.mean_px && !rows.conic && !rows.depth && !rows.opacity && !rows.color &&
      !out.channels && !absolute)
    return;
  for_each_item("boundary", sizes.gaussians, stream,
                [=, gaussians = listed.gaussians,
                 colors = in.channels ? out.channels : out.by.color] __device__(std::uint32_t i) {
                  ListedGradient gradient;
                  if (gaussians.tile_counts[i] > 0) {
                    gradient.splat =
                        splat_gradient<float>(gaussians.splats[i].splat, scratch.sums[i]);
                    if (scratch.depth_sums != nullptr)
                      gradient.depth = depth_gradient(scratch.depth_sums[i], gaussians.depths[i]);
                    if (out.absolute_px) gradient.absolute = scratch.absolute_sums[i];
                  }
                  gradient.write(i, 3, out);
                  colors.set(i, gradient.splat.color);
                });
}

}  // namespace

std::size_t bytes_to_blend_backward(const GpuHeldSizes& sizes) {
  return sizes.has_states ? bytes_of<ColorScratch>(sizes) : bytes_of<SumScratch>(sizes);
}

void blend_backward(const BlendInput& in, const Frame& frame, const Pictures<const float>& by,
                    const Queue& queue, void* scratch, const BoundaryGradients<float>& out) {
  const GpuHeldSizes& sizes = frame.sizes;
  in.check("blend_backward", sizes.has_depth, by.depth || by.inverse_depth);
  in.check_frame("blend_backward", {sizes.width, sizes.height}, static_cast<int>(sizes.channels));
  queue.throw_if_cancelled();
  const cudaStream_t stream = stream_of(queue);
  const ListedFrame listed = ListedFrame::of(frame);
  const auto state = block_at<GpuPixelBlock>(frame.pixels, sizes);
  if (sizes.has_states) {
    const auto colors = block_at<ColorScratch>(scratch, sizes);
    add_background(sizes, state, by, colors.rows, out.background, stream);
    if (sizes.gaussians > 0) color_backward(in, listed, state, by, colors, out, stream);
    return;
  }
  const auto sums = block_at<SumScratch>(scratch, sizes);
  add_background(sizes, state, by, sums.rows, out.background, stream);
  if (sizes.gaussians == 0) return;
  const SumsInput input{ChannelInput::of(listed, in), state, by};
  const GpuGaussianBlock& gaussians = listed.gaussians;
  with_general_channels(in.channel_count, [&](auto channels) {
    launch("sum_pairs", sum_channels<channels()>, tiles_of(sizes), stream, input, sums);
    sum_pairs_of_gaussians<unsigned{channels()}>(gaussians, sizes.gaussians, sums.channels,
                                                 sums.channel_sums, stream);
  });
  sum_pairs_of_gaussians<kShape>(gaussians, sizes.gaussians, sums.shapes, sums.shape_sums, stream);
  sum_pairs_of_gaussians<kAbsolute>(gaussians, sizes.gaussians, sums.absolute, sums.absolute_sums,
                                    stream);
  for_each_item(
      "boundary", sizes.gaussians, stream,
      [=, gaussians = listed.gaussians, colors = in.channels ? out.channels : out.by.color,
       channel_count = in.channel_count,
       channel_size = size_of_channels(sizes.channels)] __device__(std::uint32_t i) {
        ListedGradient gradient;
        const bool is_listed = gaussians.tile_counts[i] > 0;
        if (is_listed) {
          const float* const s = sums.shape_sums + std::size_t{i} * kShape;
          const PixelSums<float> of_pixels{s[0], s[1], s[2], s[3], s[4], s[5], glm::vec3(0.0f)};
          gradient.splat = splat_gradient<float>(gaussians.splats[i].splat, of_pixels);
          gradient.depth = s[6];
          gradient.absolute = {sums.absolute_sums[std::size_t{i} * kAbsolute],
                               sums.absolute_sums[std::size_t{i} * kAbsolute + 1]};
        }
        gradient.write(i, channel_count, out);
        const float* const of_channels = sums.channel_sums + std::size_t{i} * channel_size;
        for (int c = 0; c < channel_count && colors && is_listed; ++c)
          colors.at(i, c) = of_channels[c];
      });
}

GaussianSums sums_of_pixels(const Frame& frame, void* scratch) {
  const auto sums = block_at<ColorScratch>(scratch, frame.sizes);
  return {sums.sums, sums.depth_sums};
}

}  // namespace qs::cuda::diff
