// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/blend.cuh"
#include "raster/cuda/fast/schedule.cuh"

namespace qs::cuda::fast {
namespace {

constexpr unsigned kBatch = 128;  // list entries between two looks at what is finished
constexpr unsigned kUnroll = 4;   // queue entries at a time
constexpr unsigned kSubWidth = 8, kSubHeight = 4;       // pixels of a sub-tile
constexpr unsigned kShareHeight = 2 * kSubHeight;       // of a warp: two rows of two sub-tiles
constexpr unsigned kShares = kTileSize / kShareHeight;  // warps of a tile, one above the other
constexpr unsigned kSubTiles = 4;                       // of a warp
constexpr unsigned kLanes = kWarp / kSubTiles;          // of a sub-tile
constexpr int kPixels = kSubHeight;                     // of a lane, one above the other
static_assert(kLanes == kSubWidth && 2 * kSubWidth == kTileSize);
static_assert(kBatch % kWarp == 0 && kBatch % kUnroll == 0);

struct BlendInput {
  ScheduleView schedule;
  const KeyRange* ranges;
  const std::uint32_t* gaussians;
  const BlendRecord* records;
  int columns, rows;  // of tiles
  int width, height;  // pixels
  glm::vec3 background;
};

struct BlendOutput {
  float* color;              // null: not wanted
  std::uint32_t* evaluated;  // null: not wanted
  std::uint8_t* used;        // null: not wanted; see Pixels::used
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

/// Which sub-tiles have a pixel centre where the Gaussian counts; bit 2 * row + column. The first
/// pixel is (x0, y0) away from the mean. Over a band of rows the ellipse reaches as far as
/// its own extreme, or as the nearer end of the band, as in ExactWalk.
__device__ unsigned reached_sub_tiles(const Reach& reach, float x0, float y0) {
  const auto half_at = [&](float v) {
    return sqrt_fast(fmaxf(fmaf(-reach.narrowing * v, v, reach.half2), 0.0f));
  };
  constexpr float kRoom = 0.01f;  // pixels, for rounding
  unsigned reached = 0;
#pragma unroll
  for (unsigned s = 0; s < kSubTiles; s += 2) {
    const float low = y0 + static_cast<float>(s / 2 * kSubHeight);
    const float v0 = fmaxf(low, -reach.y_max);
    const float v1 = fminf(low + (kSubHeight - 1), reach.y_max);
    const float v_right = fminf(fmaxf(reach.v_extreme, v0), v1);
    const float v_left = fminf(fmaxf(-reach.v_extreme, v0), v1);
    const float right = fmaf(reach.slope, v_right, half_at(v_right)) + kRoom;
    const float left = fmaf(reach.slope, v_left, -half_at(v_left)) - kRoom;
#pragma unroll
    for (unsigned column = 0; column < 2; ++column) {
      const float first = x0 + static_cast<float>(column * kSubWidth);
      const bool meets = v0 <= v1 && left <= first + (kSubWidth - 1) && right >= first;
      reached |= meets ? 1u << (s + column) : 0;
    }
  }
  return reached;
}

/// A pixel while it is composited. Once it has stopped, its transmittance is kept, negative.
struct Pixel {
  float transmittance;
  float red = 0, green = 0, blue = 0;
};

/// One Gaussian on one pixel: alpha = min(2^log2_alpha, alpha_max), skipped below 1/255; the pixel
/// stops before its transmittance falls below kTransmittanceMin. Written out for the device, where
/// no branch may remain: 11 instructions, of which a comparison decides both what is added and what
/// stops. A negative transmittance stays so, since it never passes that comparison.
__device__ void composite(float log2_alpha, const Staged& splat, Pixel& pixel) {
  constexpr float kLog2Min = -kLog2Of255;
#ifdef __CUDA_ARCH__
  asm("{\n\t"
      ".reg .pred counts, adds, stops;\n\t"
      ".reg .f32 alpha, weight, next;\n\t"
      "setp.ge.f32 counts, %4, %9;\n\t"
      "ex2.approx.ftz.f32 alpha, %4;\n\t"  // relative error below 2^-22 (PTX ISA)
      "min.f32 alpha, alpha, %5;\n\t"
      "mul.f32 weight, alpha, %0;\n\t"
      "sub.f32 next, %0, weight;\n\t"
      "setp.ge.and.f32 adds|stops, next, %10, counts;\n\t"
      "@adds fma.rn.f32 %1, weight, %6, %1;\n\t"
      "@adds fma.rn.f32 %2, weight, %7, %2;\n\t"
      "@adds fma.rn.f32 %3, weight, %8, %3;\n\t"
      "@adds mov.f32 %0, next;\n\t"
      "@stops or.b32 %0, %0, 0x80000000;\n\t"
      "}"
      : "+f"(pixel.transmittance), "+f"(pixel.red), "+f"(pixel.green), "+f"(pixel.blue)
      : "f"(log2_alpha), "f"(splat.level.z), "f"(splat.level.w), "f"(splat.color.x),
        "f"(splat.color.y), "f"(kLog2Min), "f"(kTransmittanceMin));
#else
  if (!(log2_alpha >= kLog2Min)) return;  // in tests on the host
  const float weight = fminf(exp2f(log2_alpha), splat.level.z) * pixel.transmittance;
  const float next = pixel.transmittance - weight;
  if (next >= kTransmittanceMin) {
    pixel.red = fmaf(weight, splat.level.w, pixel.red);
    pixel.green = fmaf(weight, splat.color.x, pixel.green);
    pixel.blue = fmaf(weight, splat.color.y, pixel.blue);
    pixel.transmittance = next;
  } else {
    pixel.transmittance = -fabsf(pixel.transmittance);
  }
#endif
}

/// A lane's pixels, from top to bottom. Fused operations are written out, because no translation
/// unit contracts by itself (kernel/hd.h).
struct Column {
  float x, y;  // of the second pixel
  Pixel pixels[kPixels];

  __device__ bool any_live() const {
    bool any = false;
    for (const Pixel& pixel : pixels) any = any || pixel.transmittance > 0.0f;
    return any;
  }

  __device__ void add(const Staged& splat) {
    static_assert(kPixels == 4);
    const float4 shape = splat.shape, level = splat.level;
    const float dx = x - shape.x, dy = y - shape.y;
    const float along = fmaf(shape.z * dx, dx, level.y), across = shape.w * dx;
    const float here = fmaf(fmaf(level.x, dy, across), dy, along);
    const float growth = fmaf(level.x, dy + dy, across);
    composite(here - (growth - level.x), splat, pixels[0]);
    composite(here, splat, pixels[1]);
    composite(here + (growth + level.x), splat, pixels[2]);
    composite(fmaf(2.0f, fmaf(2.0f, level.x, growth), here), splat, pixels[3]);
  }
};

/// Reads the batch that begins at list entry `first`, and queues it for the sub-tiles in `live`.
/// The queues are filled up to the same length, a multiple of kUnroll, which is returned.
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

/// kMaps: fills what is wanted of BlendOutput::evaluated and used, which takes longer.
template <bool kMaps>
__global__ void __launch_bounds__(kShares* kWarp) blend_tiles(BlendInput in, BlendOutput out) {
  __shared__ Workspace workspaces[kShares];
  const unsigned tile = in.schedule.tile(blockIdx.x), share = threadIdx.x / kWarp;
  const unsigned lane = lane_index(), sub = lane / kLanes;
  Workspace& work = workspaces[share];
  const int x0 = static_cast<int>(tile % in.columns * kTileSize);
  const int y0 = static_cast<int>(tile / in.columns * kTileSize + share * kShareHeight);
  const int x = x0 + static_cast<int>(sub % 2 * kSubWidth + lane % kLanes);
  const int y = y0 + static_cast<int>(sub / 2 * kSubHeight);
  const KeyRange range = in.ranges[tile];
  const std::uint32_t begin = range.begin(), end = range.end;

  Column column{static_cast<float>(x), static_cast<float>(y + 1), {}};
  [[maybe_unused]] std::uint32_t evaluated[kPixels];
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    column.pixels[j].transmittance = x < in.width && y + j < in.height ? 1.0f : -1.0f;
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
            const float was = before.pixels[j].transmittance, is = column.pixels[j].transmittance;
            if (is < 0.0f && was > 0.0f) evaluated[j] = first - begin + entry + 1;
            used = used || (is > 0.0f && is != was);
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
      const float rest = fabsf(pixel.transmittance);
      out.color[3 * at] = fmaf(rest, in.background.x, pixel.red);
      out.color[3 * at + 1] = fmaf(rest, in.background.y, pixel.green);
      out.color[3 * at + 2] = fmaf(rest, in.background.z, pixel.blue);
    }
  }
}

}  // namespace

void blend(const FrameContext& frame, const Visible& visible, const TilePairs& pairs,
           const Scratch& scratch, const Outputs& outputs, Pixels& pixels) {
  const BlendInput in{schedule_view(scratch, frame.grid),
                      scratch.ranges,
                      pairs.gaussians.data(),
                      visible.records.data(),
                      frame.grid.columns,
                      frame.grid.rows,
                      frame.camera.width,
                      frame.camera.height,
                      frame.settings.background};
  const BlendOutput out{outputs.color ? pixels.color.data() : nullptr,
                        outputs.evaluated ? pixels.evaluated.data() : nullptr,
                        outputs.used ? pixels.used.data() : nullptr};
  launch("blend", outputs.evaluated || outputs.used ? blend_tiles<true> : blend_tiles<false>,
         Blocks(static_cast<unsigned>(frame.grid.count()), kShares * kWarp), frame.stream, in, out);
}

}  // namespace qs::cuda::fast
