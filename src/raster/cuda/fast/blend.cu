// SPDX-License-Identifier: MIT
#include "raster/cuda/blend_parameters.cuh"
#include "raster/cuda/fast/blend.cuh"
#include "raster/cuda/fast/column.cuh"
#include "raster/cuda/fast/schedule.cuh"

namespace qs::cuda::fast {
namespace {

constexpr unsigned kBatch = 128;  // list entries that a warp reads at a time
constexpr unsigned kUnroll = 4;   // queue entries processed per loop iteration
constexpr unsigned kSubWidth = 8, kSubHeight = kPixels;   // of a sub-tile in pixels
constexpr unsigned kWarpHeight = 2 * kSubHeight;          // pixel rows of a warp
constexpr unsigned kTileWarps = kTileSize / kWarpHeight;  // warps of a tile, one above the other
constexpr unsigned kSubTiles = 4;                         // of a warp, in two rows
constexpr unsigned kLanes = kWarp / kSubTiles;            // of a sub-tile
static_assert(kLanes == kSubWidth && 2 * kSubWidth == kTileSize);
static_assert(kBatch % kWarp == 0 && kBatch % kUnroll == 0);

using Input = BlendInput<KeyRange, BoundedSplat>;

/// A warp's shared memory. Queues hold indices into `staged`; the shorter ones are padded with
/// kBatch, whose entry has opacity 0.
struct Workspace {
  Staged staged[kBatch + 1];
  std::uint8_t queues[kSubTiles][kBatch];
};

/// Approximate: its callers add a margin for rounding.
__device__ float sqrt_fast(float x) {
#ifdef __CUDA_ARCH__
  float result;
  asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return sqrtf(x);
#endif
}

/// The sub-tiles that may have a pixel centre inside the ellipse, as a mask of bits 2 * row +
/// column. (x0, y0) is the offset of the warp's first pixel from the mean. Over a band of rows, the
/// ellipse is widest at its own extreme or at the end of the band nearest to it, as in ExactWalk.
__device__ unsigned reached_sub_tiles(const AlphaEllipse& ellipse, float x0, float y0) {
  const auto half_at = [&](float v) {
    return sqrt_fast(fmaxf(fmaf(-ellipse.narrowing * v, v, ellipse.half2), 0.0f));
  };
  constexpr float kMarginPx = 0.01f;  // for rounding
  unsigned reached = 0;
#pragma unroll
  for (unsigned s = 0; s < kSubTiles; s += 2) {
    const float low = y0 + static_cast<float>(s / 2 * kSubHeight);
    const float v0 = fmaxf(low, -ellipse.y_max);
    const float v1 = fminf(low + (kSubHeight - 1), ellipse.y_max);
    const float v_right = fminf(fmaxf(ellipse.v_extreme, v0), v1);
    const float v_left = fminf(fmaxf(-ellipse.v_extreme, v0), v1);
    const float right = fmaf(ellipse.slope, v_right, half_at(v_right)) + kMarginPx;
    const float left = fmaf(ellipse.slope, v_left, -half_at(v_left)) - kMarginPx;
#pragma unroll
    for (unsigned column = 0; column < 2; ++column) {
      const float first = x0 + static_cast<float>(column * kSubWidth);
      const bool meets = v0 <= v1 && left <= first + (kSubWidth - 1) && right >= first;
      reached |= meets ? 1u << (s + column) : 0;
    }
  }
  return reached;
}

/// Reads the batch that begins at list entry `first` and fills the queues of the sub-tiles in
/// `live`. Pads the queues to the same length, a multiple of kUnroll, and returns it.
__device__ unsigned fill_queues(const Input& in, std::uint32_t first, std::uint32_t end, float x0,
                                float y0, unsigned live, Workspace& work) {
  constexpr unsigned kParts = kBatch / kWarp;
  const unsigned lane = lane_index();
  std::uint32_t gaussians[kParts];
#pragma unroll
  for (unsigned part = 0; part < kParts; ++part) {
    const std::uint32_t at = first + part * kWarp + lane;
    if (at < end) gaussians[part] = in.gaussians[at];
  }
  unsigned lengths[kSubTiles] = {};
#pragma unroll
  for (unsigned part = 0; part < kParts; ++part) {
    const unsigned entry = part * kWarp + lane;
    if (first + part * kWarp >= end) break;
    unsigned reached = 0;
    if (first + entry < end) {
      const BoundedSplat splat = in.splats[gaussians[part]];
      reached = reached_sub_tiles(splat.ellipse, x0 - splat.x, y0 - splat.y) & live;
      if (reached != 0) {
        work.staged[entry] = {{splat.x, splat.y, splat.xx, splat.xy},
                              {splat.yy, splat.log2_opacity, splat.alpha_max,
                               splat.red - in.background.x},
                              {splat.green - in.background.y, splat.blue - in.background.z},
                              {}};
      }
    }
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      const bool mine = (reached >> s & 1) != 0;
      const unsigned reaching = __ballot_sync(kAllLanes, mine);
      const unsigned place = lengths[s] + __popc(reaching & lanes_below());
      if (mine) work.queues[s][place] = static_cast<std::uint8_t>(entry);
      lengths[s] += __popc(reaching);
    }
  }
  const unsigned sub = lane / kLanes;
  unsigned longest = 0, own = 0;
#pragma unroll
  for (unsigned s = 0; s < kSubTiles; ++s) {
    longest = max(longest, lengths[s]);
    if (s == sub) own = lengths[s];
  }
  const unsigned padded = (longest + kUnroll - 1) / kUnroll * kUnroll;
#pragma unroll 1
  for (unsigned i = own + lane % kLanes; i < padded; i += kLanes) {
    work.queues[sub][i] = kBatch;
  }
  __syncwarp();
  return padded;
}

/// kMaps: also fills BlendOutput::evaluated and used, which is slower.
template <bool kMaps>
__global__ void __launch_bounds__(kTileWarps* kWarp)
    blend_tiles(ScheduleView schedule, Input in, BlendOutput out) {
  __shared__ Workspace workspaces[kTileWarps];
  const unsigned tile = schedule.tile(blockIdx.x), warp = threadIdx.x / kWarp;
  const unsigned lane = lane_index(), sub = lane / kLanes;
  Workspace& work = workspaces[warp];
  const int x0 = static_cast<int>(tile % in.columns * kTileSize);
  const int y0 = static_cast<int>(tile / in.columns * kTileSize + warp * kWarpHeight);
  const int x = x0 + static_cast<int>(sub % 2 * kSubWidth + lane % kLanes);
  const int y = y0 + static_cast<int>(sub / 2 * kSubHeight);
  const KeyRange range = in.ranges[tile];
  const std::uint32_t begin = range.begin(), end = range.end;

  Column column{static_cast<float>(x), static_cast<float>(y + 1), {}};
  [[maybe_unused]] std::uint32_t evaluated[kPixels];
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    column.pixels[j] = {x < in.width && y + j < in.height ? 1.0f : 0.0f, in.background.x,
                        in.background.y, in.background.z};
    evaluated[j] = end - begin;
  }
  if (lane == 0) work.staged[kBatch] = {{}, {0, -INFINITY, 0, 0}, {}, {}};

  for (std::uint32_t first = begin; first < end; first += kBatch) {
    const unsigned live_lanes = __ballot_sync(kAllLanes, column.any_live());
    if (live_lanes == 0) break;
    unsigned live = 0;
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      if ((live_lanes >> (s * kLanes) & ((1u << kLanes) - 1)) != 0) live |= 1u << s;
    }
    const unsigned length =
        fill_queues(in, first, end, static_cast<float>(x0), static_cast<float>(y0), live, work);
    const std::uint8_t* queue = work.queues[sub];
    for (unsigned i = 0; i < length; i += kUnroll) {
#pragma unroll
      for (unsigned k = 0; k < kUnroll; ++k) {
        const unsigned entry = queue[i + k];
        if constexpr (!kMaps) {
          column.add(work.staged[entry]);
        } else {
          const Column before = column;
          column.add(work.staged[entry]);
          bool used = false;
          for (int j = 0; j < kPixels; ++j) {
            const Pixel &was = before.pixels[j], &is = column.pixels[j];
            if (was.is_live() && !is.is_live()) evaluated[j] = first - begin + entry + 1;
            used = used || (is.is_live() && is.transmittance != was.transmittance);
          }
          if (used && out.used != nullptr) out.used[first + entry] = 1;
        }
      }
    }
    __syncwarp();
  }

  if (x >= in.width) return;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    if (y + j >= in.height) return;
    const std::size_t at = static_cast<std::size_t>(y + j) * in.width + x;
    if constexpr (kMaps) {
      if (out.evaluated != nullptr) out.evaluated[at] = evaluated[j];
    }
    if (out.color != nullptr) {
      const Pixel& pixel = column.pixels[j];
      out.color[3 * at] = pixel.red;
      out.color[3 * at + 1] = pixel.green;
      out.color[3 * at + 2] = pixel.blue;
    }
  }
}

}  // namespace

void blend(const FrameContext& frame, const Visible& visible, const TilePairs& pairs,
           const Scratch& scratch, const Outputs& outputs, Pixels& pixels) {
  launch("blend", outputs.evaluated || outputs.used ? blend_tiles<true> : blend_tiles<false>,
         Blocks(static_cast<unsigned>(frame.grid.count()), kTileWarps * kWarp), frame.stream,
         schedule_view(scratch, frame.grid),
         Input::of(frame, pairs.gaussians, std::as_const(scratch.ranges), visible.splats),
         BlendOutput::of(pixels, outputs));
}

}  // namespace qs::cuda::fast
