// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/blend.cuh"

namespace qs::cuda::fast {
namespace {

constexpr unsigned kBatch = 128;  // list entries between two looks at what is finished
constexpr unsigned kGroup = 8;    // queue entries between two looks at what must stop
constexpr unsigned kSubTiles = 4;
constexpr unsigned kSubWidth = 8, kSubHeight = 4;      // pixels
constexpr unsigned kQuarter = kWarp / kSubTiles;       // lanes of a sub-tile
constexpr unsigned kHalfHeight = 2 * kSubHeight;       // of a warp's pixels: two rows of sub-tiles
constexpr unsigned kHalves = kTileSize / kHalfHeight;  // warps of a tile
constexpr int kPixels = kSubHeight;                    // of a lane
static_assert(kQuarter == kSubWidth && 2 * kSubWidth == kTileSize && kBatch % kGroup == 0);

struct BlendInput {
  const KeyRange* ranges;
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

/// What a queue's entry leads to in shared memory.
struct Staged {
  float4 shape;  // x, y, xx, xy
  float4 level;  // yy, log2_opacity, alpha_max, red
  float2 color;  // green, blue
  float2 unused;
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

/// Enough for a test that has room for rounding.
__device__ float sqrt_fast(float x) {
#ifdef __CUDA_ARCH__
  float result;
  asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return sqrtf(x);
#endif
}

/// Which of the four sub-tiles have a pixel centre where the Gaussian counts; bit 2 * row + column.
/// The first pixel is (x0, y0) away from the mean. Over a band of rows the ellipse reaches as far
/// as its own extreme, or as the nearer end of the band, as in ExactWalk.
__device__ unsigned reached_sub_tiles(const Reach& reach, float x0, float y0) {
  unsigned reached = 0;
#pragma unroll
  for (unsigned row = 0; row < 2; ++row) {
    const float low = y0 + static_cast<float>(row * kSubHeight);
    const float v0 = fmaxf(low, -reach.y_max), v1 = fminf(low + (kSubHeight - 1), reach.y_max);
    const auto half_at = [&](float v) {
      return sqrt_fast(fmaxf(fmaf(-reach.narrowing * v, v, reach.half2), 0.0f));
    };
    const float v_right = fminf(fmaxf(reach.v_extreme, v0), v1);
    const float v_left = fminf(fmaxf(-reach.v_extreme, v0), v1);
    constexpr float kRoom = 0.01f;  // pixels, for rounding
    const float right = fmaf(reach.slope, v_right, half_at(v_right)) + kRoom;
    const float left = fmaf(reach.slope, v_left, -half_at(v_left)) - kRoom;
#pragma unroll
    for (unsigned column = 0; column < 2; ++column) {
      const float first = x0 + static_cast<float>(column * kSubWidth);
      const bool meets = v0 <= v1 && left <= first + (kSubWidth - 1) && right >= first;
      reached |= meets ? 1u << (2 * row + column) : 0;
    }
  }
  return reached;
}

/// What became of a pixel so far.
struct Pixels4 {
  float transmittance[kPixels];  // 0 once the pixel has stopped
  float red[kPixels] = {}, green[kPixels] = {}, blue[kPixels] = {};

  __device__ void add(int j, const Staged& splat, float weight) {
    red[j] = fmaf(weight, splat.level.w, red[j]);
    green[j] = fmaf(weight, splat.color.x, green[j]);
    blue[j] = fmaf(weight, splat.color.y, blue[j]);
  }

  /// What remains of the light comes from the background.
  __device__ void stop(int j, glm::vec3 background) {
    red[j] = fmaf(transmittance[j], background.x, red[j]);
    green[j] = fmaf(transmittance[j], background.y, green[j]);
    blue[j] = fmaf(transmittance[j], background.z, blue[j]);
    transmittance[j] = 0;
  }

  __device__ bool any_live() const {
    bool any = false;
    for (const float t : transmittance) any = any || t > 0.0f;
    return any;
  }

  /// A pixel has gone beyond where it should have stopped.
  __device__ bool any_too_dark() const {
    bool any = false;
    for (const float t : transmittance) any = any || (t > 0.0f && t < kTransmittanceMin);
    return any;
  }
};

/// A Gaussian on a lane's pixels, from top to bottom. Fused operations are written out, because no
/// translation unit contracts by itself (kernel/hd.h). `x` and `y` belong to the second pixel.
struct Exponents {
  float log2_alpha[kPixels];

  __device__ Exponents(const Staged& splat, float x, float y) {
    const float4 shape = splat.shape, level = splat.level;
    const float dx = x - shape.x, dy = y - shape.y;
    const float along = fmaf(shape.z * dx, dx, level.y), across = shape.w * dx;
    const float here = fmaf(fmaf(level.x, dy, across), dy, along);
    const float growth = fmaf(level.x, dy + dy, across);
    log2_alpha[0] = here - (growth - level.x);
    log2_alpha[1] = here;
    log2_alpha[2] = here + (growth + level.x);
    log2_alpha[3] = fmaf(2.0f, fmaf(2.0f, level.x, growth), here);
  }

  __device__ bool counts(int j) const { return log2_alpha[j] >= -BlendRecord::kLog2Of255; }
  __device__ float alpha(int j, const Staged& splat) const {
    return fminf(exp2_fast(log2_alpha[j]), splat.level.z);
  }
};

/// Composites without asking whether a pixel should stop.
__device__ void add_unchecked(const Staged& splat, float x, float y, Pixels4& pixels) {
  const Exponents exponents(splat, x, y);
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const float weight = exponents.alpha(j, splat) * pixels.transmittance[j];
    if (exponents.counts(j)) {
      pixels.add(j, splat, weight);
      pixels.transmittance[j] -= weight;
    }
  }
}

/// The same with the rule: a pixel stops before its transmittance falls below kTransmittanceMin.
/// Calls stopped(j).
template <class Stopped>
__device__ void add_checked(const Staged& splat, float x, float y, glm::vec3 background,
                            Pixels4& pixels, const Stopped& stopped) {
  const Exponents exponents(splat, x, y);
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const float weight = exponents.alpha(j, splat) * pixels.transmittance[j];
    if (!exponents.counts(j) || pixels.transmittance[j] == 0.0f) continue;
    if (pixels.transmittance[j] - weight < kTransmittanceMin) {
      pixels.stop(j, background);
      stopped(j);
    } else {
      pixels.add(j, splat, weight);
      pixels.transmittance[j] -= weight;
    }
  }
}

/// Reads the batch that begins at list entry `first`, and queues it for the sub-tiles in `live`.
/// The queues are filled up to the same length, a multiple of kGroup, which is returned.
__device__ unsigned fill_queues(const BlendInput& in, std::uint32_t first, std::uint32_t end,
                                float x0, float y0, unsigned live, Workspace& work) {
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
      const BlendRecord splat = in.records[gaussians[part]];
      reached = reached_sub_tiles(splat.reach, x0 - splat.x, y0 - splat.y) & live;
      if (reached != 0) {
        work.staged[entry] = {{splat.x, splat.y, splat.xx, splat.xy},
                              {splat.yy, splat.log2_opacity, splat.alpha_max, splat.red},
                              {splat.green, splat.blue},
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
  const unsigned longest = max(max(lengths[0], lengths[1]), max(lengths[2], lengths[3]));
  const unsigned padded = (longest + kGroup - 1) / kGroup * kGroup;
  const unsigned sub = lane / kQuarter;
  const unsigned own =
      sub < 2 ? (sub == 0 ? lengths[0] : lengths[1]) : (sub == 2 ? lengths[2] : lengths[3]);
#pragma unroll 1
  for (unsigned i = own + lane % kQuarter; i < padded; i += kQuarter) work.queues[sub][i] = kBatch;
  __syncwarp();
  return padded;
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
  const KeyRange range = in.ranges[tile];
  const std::uint32_t begin = range.begin(), end = range.end;
  if (threadIdx.x == 0 && end - begin > out.counters->max_pairs_in_a_tile) {
    atomicMax(&out.counters->max_pairs_in_a_tile, end - begin);
  }

  Pixels4 pixels;
  [[maybe_unused]] std::uint32_t evaluated[kPixels];
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    pixels.transmittance[j] = x < in.width && y + j < in.height ? 1.0f : 0.0f;
    evaluated[j] = end - begin;
  }
  const float second_x = static_cast<float>(x), second_y = static_cast<float>(y + 1);
  if (lane == 0) work.staged[kBatch] = {{}, {0, -INFINITY, 0, 0}, {}, {}};

  for (std::uint32_t first = begin; first < end; first += kBatch) {
    const unsigned live_lanes = __ballot_sync(kAllLanes, pixels.any_live());
    if (live_lanes == 0) break;
    unsigned live = 0;
#pragma unroll
    for (unsigned s = 0; s < kSubTiles; ++s) {
      if ((live_lanes >> (s * kQuarter) & ((1u << kQuarter) - 1)) != 0) live |= 1u << s;
    }
    const unsigned length =
        fill_queues(in, first, end, static_cast<float>(x0), static_cast<float>(y0), live, work);
    for (unsigned group = 0; group < length; group += kGroup) {
      const std::uint8_t* queue = &work.queues[sub][group];
      const Pixels4 before = pixels;
#pragma unroll
      for (unsigned k = 0; k < kGroup; ++k) {
        add_unchecked(work.staged[queue[k]], second_x, second_y, pixels);
      }
      if (!pixels.any_too_dark()) continue;
      pixels = before;
#pragma unroll 1
      for (unsigned k = 0; k < kGroup; ++k) {
        const unsigned entry = queue[k];
        add_checked(work.staged[entry], second_x, second_y, in.background, pixels, [&](int j) {
          if constexpr (kEvaluated) evaluated[j] = first - begin + entry + 1;
        });
      }
    }
    __syncwarp();
  }

  if (x >= in.width) return;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    if (y + j >= in.height) return;
    pixels.stop(j, in.background);
    const std::size_t at = static_cast<std::size_t>(y + j) * in.width + x;
    if constexpr (kEvaluated) out.evaluated[at] = evaluated[j];
    if (out.color != nullptr) {
      out.color[3 * at] = pixels.red[j];
      out.color[3 * at + 1] = pixels.green[j];
      out.color[3 * at + 2] = pixels.blue[j];
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
