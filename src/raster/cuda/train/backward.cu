// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/train/backward.cuh"
#include "raster/cuda/train/segment.cuh"

namespace qs::cuda::train {
namespace {

constexpr unsigned kWarps = kTilePixels / kWarp;
constexpr unsigned kSums = 9;  // numbers of PixelSums
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
__device__ float fold(float without, float with) {
  const bool bit = (lane_index() & kDistance) != 0;
  const float sent = bit ? without : with, kept = bit ? with : without;
  return kept + __shfl_xor_sync(kAllLanes, sent, kDistance);
}

/// Sums over the lanes of a warp into `result`, of kSums numbers. Every exchange halves the numbers
/// that a lane holds. All lanes call it.
__device__ void sum_of_warp(const PixelSums<float>& sums, float* result) {
  const float a[] = {fold<16>(sums.d, sums.dx), fold<16>(sums.dy, sums.dxx),
                     fold<16>(sums.dxy, sums.dyy), fold<16>(sums.color.x, sums.color.y)};
  const float b[] = {fold<8>(a[0], a[1]), fold<8>(a[2], a[3])};
  const float blue = fold<4>(fold<8>(fold<16>(sums.color.z)));
  const float total = fold<1>(fold<2>(fold<4>(b[0], b[1]), blue));
  const unsigned lane = lane_index();
  if (lane % 4 == 0) result[lane / 4 % 2 * 4 + lane / 8 % 2 * 2 + lane / 16] = total;
  if (lane == 2) result[kSums - 1] = total;
}

/// The same for two numbers.
__device__ void sum_of_warp(const glm::vec2& sums, float* result) {
  const float total = fold<1>(fold<2>(fold<4>(fold<8>(fold<16>(sums.x, sums.y)))));
  const unsigned lane = lane_index();
  if (lane % 16 == 0) result[lane / 16] = total;
}

__device__ float dot(const glm::vec3& a, const glm::vec3& b) {
  return fmaf(a.x, b.x, fmaf(a.y, b.y, a.z * b.z));
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
    d_color = in.d_color[at];
    const float4 state = in.states[std::size_t{blockIdx.x} * kTilePixels + threadIdx.x];
    product = dot(d_color, in.color[at]);
    so_far = {state.x, state.y, state.z};
    transmittance = state.w;
  }

  /// Sets `sums` to the pixel's share of the Gaussian's sums, as add_pixel() of the CPU. If the
  /// pixel does not blend the Gaussian, the share is zero and the result false. A pixel never stops
  /// below `end`.
  __device__ bool add(const Contribution& by, bool exists, PixelSums<float>& sums) {
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
    sums.d = blends ? by.unclamped * d_alpha : 0.0f;
    sums.dx = sums.d * by.dx;
    sums.dy = sums.d * by.dy;
    sums.dxx = sums.dx * by.dx;
    sums.dxy = sums.dx * by.dy;
    sums.dyy = sums.dy * by.dy;
    const float shown = blends ? weight : 0.0f;
    sums.color = shown * d_color;
    if (blends) {
      so_far = next;
      transmittance = by.behind(transmittance);
    }
    return blends;
  }
};

/// The absolute values of a pixel's part of the derivative by the mean, see add_pixel().
__device__ glm::vec2 absolute_of(const SharedSegment& segment, std::uint32_t entry,
                                 const PixelSums<float>& sums) {
  const float conic_x = segment.shapes[entry].z, conic_y = segment.shapes[entry].w,
              conic_z = segment.lights[entry].x;
  return static_cast<float>(kLn2) * glm::vec2(fabsf(fmaf(2 * conic_x, sums.dx, conic_y * sums.dy)),
                                              fabsf(fmaf(2 * conic_z, sums.dy, conic_y * sums.dx)));
}

struct PairSums {
  PixelSums<float>* pairs;
  glm::vec2* absolute;  ///< if kAbsolute
};

/// One block per segment.
template <bool kAbsolute>
__global__ void __launch_bounds__(kTilePixels) sum_pairs(PairInput in, PairSums out) {
  constexpr unsigned kNumbers = kSums + (kAbsolute ? 2 : 0);  // per pair
  __shared__ SharedSegment segment;
  __shared__ float sums_of_warps[kWarps][kWarp * kNumbers];
  const std::uint32_t tile = in.segment_tiles[blockIdx.x];
  if (tile == kNoTile) return;
  const uint2 range = in.tiles.ranges[tile];
  const std::uint32_t first = (blockIdx.x - first_segment(range.x, tile)) * kSegment;
  const std::uint32_t size = min(range.y - range.x - first, kSegment);
  segment.load(in.tiles, tile, range.x + first, size);
  SegmentPixel pixel(in, tile, first);
  const unsigned end_of_warp = largest_of_warp(pixel.end);
  float* const own = sums_of_warps[threadIdx.x / kWarp];
  for (std::uint32_t group = 0; group < size; group += kWarp) {
    if (__syncthreads_count(pixel.end > group) == 0) break;
    for (unsigned k = 0; k < kNumbers; ++k) own[k * kWarp + lane_index()] = 0;
    __syncwarp();
    for (unsigned reaching = segment.reaching(group, min(size, end_of_warp)); reaching != 0;
         reaching &= reaching - 1) {
      const unsigned member = lowest_bit(reaching);
      PixelSums<float> sums;
      const Contribution by = segment.contribution(group + member, pixel.x, pixel.y);
      const bool blends = pixel.add(by, group + member < pixel.end, sums);
      if (!__any_sync(kAllLanes, blends)) continue;
      sum_of_warp(sums, own + member * kNumbers);
      if constexpr (kAbsolute) {
        sum_of_warp(absolute_of(segment, group + member, sums), own + member * kNumbers + kSums);
      }
    }
    __syncthreads();
    for (unsigned k = threadIdx.x; k < kWarp * kNumbers; k += kTilePixels) {
      const std::uint32_t entry = group + k / kNumbers;
      if (entry >= size) break;
      float sum = 0;
      for (unsigned warp = 0; warp < kWarps; ++warp) sum += sums_of_warps[warp][k];
      const std::uint32_t place = in.tiles.places[range.x + first + entry];
      const unsigned number = k % kNumbers;
      if (number < kSums)
        reinterpret_cast<float*>(out.pairs + place)[number] = sum;
      else
        reinterpret_cast<float*>(out.absolute + place)[number - kSums] = sum;
    }
  }
}

/// The sum of values[k * kNumbers] for k in [begin, end), in this order. The loads of a group do
/// not wait for each other.
template <unsigned kNumbers, unsigned kGroup>
__device__ void add_groups(const float* values, std::uint32_t& begin, std::uint32_t end,
                           float& sum) {
  for (; begin + kGroup <= end; begin += kGroup) {
    float group[kGroup];
#pragma unroll
    for (unsigned k = 0; k < kGroup; ++k) group[k] = values[std::size_t{begin + k} * kNumbers];
#pragma unroll
    for (unsigned k = 0; k < kGroup; ++k) sum += group[k];
  }
}

/// One thread per number of a rank's kNumbers sums, so the threads of a Gaussian read neighbouring
/// addresses. The gradients are computed in another kernel, which need not wait for the long lists
/// of large Gaussians.
template <unsigned kNumbers>
__global__ void __launch_bounds__(kThreads)
    sum_gaussians(std::uint32_t count, const std::uint32_t* gaussians, const std::uint64_t* offsets,
                  const float* pairs, float* sums) {
  const std::uint64_t thread = std::uint64_t{blockIdx.x} * kThreads + threadIdx.x;
  const auto rank = static_cast<std::uint32_t>(thread / kNumbers);
  if (rank >= count) return;
  const auto k = static_cast<unsigned>(thread % kNumbers);
  const float* const values = pairs + k;
  auto begin = static_cast<std::uint32_t>(offsets[rank]);
  const auto end = static_cast<std::uint32_t>(offsets[rank + 1]);
  float sum = 0;
  add_groups<kNumbers, 32>(values, begin, end, sum);
  add_groups<kNumbers, 4>(values, begin, end, sum);
  add_groups<kNumbers, 1>(values, begin, end, sum);
  sums[std::size_t{gaussians[rank]} * kNumbers + k] = sum;
}

template <unsigned kNumbers>
void launch_sums(const StepView& view, std::uint32_t count, const DepthOrder& order,
                 const void* pairs, void* sums) {
  launch("sum_gaussians", sum_gaussians<kNumbers>, blocks_for(std::uint64_t{kNumbers} * count),
         view.stream, count, order.gaussians(), order.offsets.data(),
         static_cast<const float*>(pairs), static_cast<float*>(sums));
}

struct GaussianInput {
  GradientRules<float> rules;
  ParametersView parameters;
  const std::uint32_t* tile_counts;  ///< 0: not visible
  const PixelSums<float>* sums;      ///< per Gaussian
  const ListedSplat* splats;
};

/// One thread per Gaussian.
__global__ void __launch_bounds__(kThreads)
    gaussian_gradients(GaussianInput in, ParametersView out, glm::vec2* d_mean_px) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= in.parameters.count) return;
  const auto set_coefficient = [&](int k, const glm::vec3& by) { out.set_coefficient(i, k, by); };
  GaussianValues<float> gradient{glm::vec3(0.0f), glm::vec3(0.0f), glm::quat(0, 0, 0, 0), 0.0f};
  glm::vec2 mean_px(0.0f);
  int set = 0;  // coefficients
  if (in.tile_counts[i] > 0) {
    const SplatGradient<float> splat = splat_gradient<float>(in.splats[i].splat, in.sums[i]);
    gradient = gaussian_gradient<float>(
        in.rules, in.parameters.gaussian(i), [&](int k) { return in.parameters.coefficient(i, k); },
        splat, set_coefficient);
    mean_px = splat.mean_px;
    set = (in.rules.sh_degree + 1) * (in.rules.sh_degree + 1);
  }
  for (int k = set; k < in.parameters.sh_coefficients; ++k) set_coefficient(k, glm::vec3(0.0f));
  out.set_gaussian(i, gradient);
  d_mean_px[i] = mean_px;
}

void sum_pairs_of_tiles(const StepView& view, const ForwardFrame& frame, const glm::vec3* d_color,
                        bool absolute, BackwardScratch& scratch) {
  const std::uint32_t count = frame.pairs.count;
  if (count == 0) return;
  scratch.pairs.reserve("the step's pairs", frame.room());
  if (absolute) scratch.absolute.reserve("the step's pairs", frame.room());
  // Pairs that no pixel reached keep 0.
  check(cudaMemsetAsync(scratch.pairs.data(), 0, count * sizeof(PixelSums<float>), view.stream),
        "backward");
  if (absolute) {
    check(cudaMemsetAsync(scratch.absolute.data(), 0, count * sizeof(glm::vec2), view.stream),
          "backward");
  }
  launch("sum_pairs", absolute ? sum_pairs<true> : sum_pairs<false>,
         Blocks(frame.segments, kTilePixels), view.stream,
         PairInput{frame.tiles(view), frame.segment_tiles.data(), frame.states.data(),
                   frame.color.data(), frame.last.data(), d_color},
         PairSums{scratch.pairs.data(), scratch.absolute.data()});
}

}  // namespace

void backward(const StepView& view, Parameters& parameters, ForwardFrame& frame,
              const glm::vec3* d_color, const qs::train::BackwardOrder& order,
              BackwardScratch& scratch, Gradients& gradients) {
  gradients.by.resize(parameters.count, parameters.sh_degree);
  gradients.mean_px.reserve("the gradients", with_room(parameters.count));
  gradients.has_absolute = order.absolute;
  if (order.absolute) gradients.absolute_px.reserve("the gradients", with_room(parameters.count));
  scratch.sums.reserve("the gradients", with_room(parameters.count));
  if (parameters.count == 0) return;
  view.throw_if_cancelled();
  sum_pairs_of_tiles(view, frame, d_color, order.absolute, scratch);
  const GradientRules<float> rules{make_view<float>(view.camera), view.settings.dilation,
                                   view.antialiased(),
                                   std::min(view.settings.sh_degree, parameters.sh_degree)};
  const GaussianInput in{rules, parameters.view(), frame.tile_counts.data(), scratch.sums.data(),
                         frame.splats.data()};
  launch_sums<kSums>(view, parameters.count, frame.order, scratch.pairs.data(),
                     scratch.sums.data());
  if (order.absolute) {
    launch_sums<2>(view, parameters.count, frame.order, scratch.absolute.data(),
                   gradients.absolute_px.data());
  }
  launch("gaussian_gradients", gaussian_gradients, blocks_for(parameters.count), view.stream, in,
         gradients.by.view(), gradients.mean_px.data());
}

}  // namespace qs::cuda::train
