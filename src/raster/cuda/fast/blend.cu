// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/blend.cuh"

namespace qs::cuda::fast {
namespace {

constexpr unsigned kBatch = 128;  // list entries between two looks at what is finished
constexpr unsigned kSubTiles = 4;
constexpr unsigned kSubWidth = 8, kSubHeight = 4;      // pixels
constexpr unsigned kQuarter = kWarp / kSubTiles;       // lanes of a sub-tile
constexpr unsigned kHalfHeight = 2 * kSubHeight;       // of a warp's pixels, two rows of sub-tiles
constexpr unsigned kHalves = kTileSize / kHalfHeight;  // warps of a tile
constexpr int kPixels = kSubHeight;                    // of a lane
static_assert(kQuarter == kSubWidth && 2 * kSubWidth == kTileSize);

struct BlendInput {
  const uint2* ranges;
  const std::uint32_t* gaussians;
  const BlendRecord* records;
  TileGrid grid;
  int width, height;  // pixels
  glm::vec3 background;
};

struct BlendOutput {
  float* color;              // null: not wanted
  std::uint32_t* evaluated;  // null: not wanted
  Counters* counters;
};

/// What a queue's entry leads to in shared memory: three reads of 16 bytes.
struct Staged {
  float4 shape;  // x, y, xx, xy
  float4 level;  // yy, log2_opacity, alpha_max, red
  float4 color;  // green, blue, -, -
};

/// A warp's shared memory. Entry kBatch of `staged` never counts: it fills up the shorter queues.
struct Workspace {
  Staged staged[kBatch + 1];
  std::uint8_t queues[kSubTiles][kBatch];
};

/// 2^x in one instruction, relative error below 2^-22 (PTX ISA, ex2.approx); results below 2^-126
/// become 0.
__device__ float exp2_fast(float x) {
#ifdef __CUDA_ARCH__
  float result;
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return exp2f(x);  // in tests on the host
#endif
}

/// Which of the four sub-tiles have a pixel centre in the ellipse of pixels that count; bit
/// 2 * row + column. (x0, y0) is the first pixel. In a band of rows the ellipse reaches from its
/// own extreme, or from the nearer end of the band, as in ExactWalk.
__device__ unsigned reached_sub_tiles(const BlendRecord& splat, float x0, float y0) {
  const float slope = -0.5f * splat.xy / splat.xx;  // of the ellipse's middle along a row
  const float v_extreme = -0.5f * splat.xy / splat.yy * splat.x_max;
  const float level = splat.log2_opacity + BlendRecord::kLog2Of255;
  const float half_at_center = sqrtf(level / -splat.xx) * 1.0005f;
  const float inverse_y_max = 1.0f / splat.y_max;
  constexpr float kRoom = 0.01f;  // pixels, for rounding
  unsigned reached = 0;
#pragma unroll
  for (unsigned row = 0; row < 2; ++row) {
    const float low = y0 + static_cast<float>(row * kSubHeight) - splat.y;
    const float v0 = fmaxf(low, -splat.y_max), v1 = fminf(low + (kSubHeight - 1), splat.y_max);
    if (!(v0 <= v1)) continue;
    const auto half_at = [&](float v) {
      const float part = v * inverse_y_max;
      return half_at_center * sqrtf(fmaxf(fmaf(-part, part, 1.0f), 0.0f)) + kRoom;
    };
    const float v_right = fminf(fmaxf(v_extreme, v0), v1);
    const float v_left = fminf(fmaxf(-v_extreme, v0), v1);
    const float right = splat.x + fmaf(slope, v_right, half_at(v_right));
    const float left = splat.x + fmaf(slope, v_left, -half_at(v_left));
#pragma unroll
    for (unsigned column = 0; column < 2; ++column) {
      const float first = x0 + static_cast<float>(column * kSubWidth);
      if (left <= first + (kSubWidth - 1) && right >= first) reached |= 1u << (2 * row + column);
    }
  }
  return reached;
}

/// A lane's pixels while they are composited, from top to bottom. The transmittance of a pixel that
/// has stopped is kept, negative.
struct Column {
  float x, y;  // of the second pixel
  float transmittance[kPixels];
  float red[kPixels] = {}, green[kPixels] = {}, blue[kPixels] = {};

  __device__ bool live() const {
    bool any = false;
    for (const float t : transmittance) any = any || t > 0.0f;
    return any;
  }

  /// Fused operations are written out, because no translation unit contracts by itself
  /// (kernel/hd.h). stopped(j) is called when a pixel stops here.
  template <class Stopped>
  __device__ void add(const Staged& splat, const Stopped& stopped) {
    const float4 shape = splat.shape, level = splat.level;
    const float2 color{splat.color.x, splat.color.y};
    const float dx = x - shape.x, dy = y - shape.y;
    // log2 alpha at the second pixel, and its growth downwards.
    const float along = fmaf(shape.z * dx, dx, level.y), across = shape.w * dx;
    const float here = fmaf(fmaf(level.x, dy, across), dy, along);
    const float growth = fmaf(level.x, dy + dy, across);
    const float log2_alpha[kPixels] = {here - (growth - level.x), here, here + (growth + level.x),
                                       fmaf(2.0f, fmaf(2.0f, level.x, growth), here)};
#pragma unroll
    for (int j = 0; j < kPixels; ++j) {
      const bool counts = log2_alpha[j] >= -BlendRecord::kLog2Of255;
      const float alpha = fminf(exp2_fast(log2_alpha[j]), level.z);
      const float weight = alpha * transmittance[j];
      const float next = transmittance[j] - weight;
      const bool goes_on = counts && next >= kTransmittanceMin;
      if (counts && !goes_on && transmittance[j] > 0.0f) stopped(j);
      if (counts) transmittance[j] = goes_on ? next : -fabsf(transmittance[j]);
      if (goes_on) {
        red[j] = fmaf(weight, level.w, red[j]);
        green[j] = fmaf(weight, color.x, green[j]);
        blue[j] = fmaf(weight, color.y, blue[j]);
      }
    }
  }
};

/// Reads the batch that begins at list entry `first`, and queues it for the sub-tiles in `live`.
/// The queues end up equally long; their length.
__device__ unsigned fill_queues(const BlendInput& in, std::uint32_t first, std::uint32_t end,
                                float x0, float y0, unsigned live, Workspace& work) {
  unsigned lengths[kSubTiles] = {};
  const unsigned lane = lane_index();
  for (unsigned part = 0; part < kBatch && first + part < end; part += kWarp) {
    const unsigned entry = part + lane;
    unsigned reached = 0;
    if (first + entry < end) {
      const BlendRecord splat = in.records[in.gaussians[first + entry]];
      reached = reached_sub_tiles(splat, x0, y0) & live;
      if (reached != 0) {
        work.staged[entry] = {{splat.x, splat.y, splat.xx, splat.xy},
                              {splat.yy, splat.log2_opacity, splat.alpha_max, splat.red},
                              {splat.green, splat.blue, 0, 0}};
      }
    }
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      const bool mine = (reached >> s & 1) != 0;
      const unsigned reaching = __ballot_sync(kAllLanes, mine);
      if (mine) {
        work.queues[s][lengths[s] + __popc(reaching & lanes_below())] =
            static_cast<std::uint8_t>(entry);
      }
      lengths[s] += __popc(reaching);
    }
  }
  const unsigned longest = max(max(lengths[0], lengths[1]), max(lengths[2], lengths[3]));
#pragma unroll
  for (unsigned s = 0; s < kSubTiles; ++s) {
    for (unsigned i = lengths[s] + lane; i < longest; i += kWarp) work.queues[s][i] = kBatch;
  }
  __syncwarp();
  return longest;
}

template <bool kEvaluated>
__global__ void __launch_bounds__(kHalves* kWarp) blend_tiles(BlendInput in, BlendOutput out) {
  __shared__ Workspace workspaces[kHalves];
  const unsigned tile = blockIdx.x, half = threadIdx.x / kWarp, lane = lane_index();
  const unsigned sub = lane / kQuarter;
  Workspace& work = workspaces[half];
  const int x0 = static_cast<int>(tile % in.grid.columns * kTileSize);
  const int y0 = static_cast<int>(tile / in.grid.columns * kTileSize + half * kHalfHeight);
  const int x = x0 + static_cast<int>(sub % 2 * kSubWidth + lane % kQuarter);
  const int y = y0 + static_cast<int>(sub / 2 * kSubHeight);
  const uint2 range = in.ranges[tile];
  const std::uint32_t begin = range.x, end = range.y;
  if (threadIdx.x == 0 && end - begin > out.counters->max_pairs_in_a_tile) {
    atomicMax(&out.counters->max_pairs_in_a_tile, end - begin);
  }

  Column column{static_cast<float>(x), static_cast<float>(y + 1), {}};
  [[maybe_unused]] std::uint32_t evaluated[kPixels];
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    column.transmittance[j] = x < in.width && y + j < in.height ? 1.0f : -1.0f;
    evaluated[j] = end - begin;
  }
  if (lane == 0) work.staged[kBatch] = {{}, {0, -INFINITY, 0, 0}, {}};

  for (std::uint32_t first = begin; first < end; first += kBatch) {
    const unsigned live_lanes = __ballot_sync(kAllLanes, column.live());
    if (live_lanes == 0) break;
    unsigned live = 0;
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      if ((live_lanes >> (s * kQuarter) & ((1u << kQuarter) - 1)) != 0) live |= 1u << s;
    }
    const unsigned length =
        fill_queues(in, first, end, static_cast<float>(x0), static_cast<float>(y0), live, work);
#pragma unroll 2
    for (unsigned i = 0; i < length; ++i) {
      const unsigned entry = work.queues[sub][i];
      column.add(work.staged[entry], [&](int j) {
        if constexpr (kEvaluated) evaluated[j] = first - begin + entry + 1;
      });
    }
    __syncwarp();
  }

  if (x >= in.width) return;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    if (y + j >= in.height) return;
    const std::size_t at = static_cast<std::size_t>(y + j) * in.width + x;
    if constexpr (kEvaluated) out.evaluated[at] = evaluated[j];
    if (out.color != nullptr) {
      const float rest = fabsf(column.transmittance[j]);
      out.color[3 * at] = fmaf(rest, in.background.x, column.red[j]);
      out.color[3 * at + 1] = fmaf(rest, in.background.y, column.green[j]);
      out.color[3 * at + 2] = fmaf(rest, in.background.z, column.blue[j]);
    }
  }
}

}  // namespace

void blend(const FrameContext& frame, const Visible& visible, const TilePairs& pairs,
           const Scratch& scratch, const Outputs& outputs, Pixels& pixels) {
  const BlendInput in{
      scratch.ranges,     pairs.gaussians.data(), visible.records.data(),   frame.grid,
      frame.camera.width, frame.camera.height,    frame.settings.background};
  const BlendOutput out{outputs.color ? pixels.color.data() : nullptr,
                        outputs.evaluated ? pixels.evaluated.data() : nullptr, scratch.counters};
  launch("blend", outputs.evaluated ? blend_tiles<true> : blend_tiles<false>,
         Blocks(static_cast<unsigned>(frame.grid.count()), kHalves * kWarp), frame.stream, in, out);
}

}  // namespace qs::cuda::fast
