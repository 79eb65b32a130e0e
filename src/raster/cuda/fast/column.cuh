// SPDX-License-Identifier: MIT
//
// Compositing of one Gaussian onto the pixels of one lane: the inner loop of the blend stage.
// Gaussians wait for it in queues in shared memory, one for each of a warp's sub-tiles. All four
// queues begin at the same slot, because they advance together.
#pragma once

#include "raster/cuda/common/flush.cuh"
#include "raster/cuda/common/sub_tiles.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/constants.h"

namespace qs::cuda::fast {

constexpr int kPixels = 4;  // of a lane, one above the other

/// A Gaussian as it is composited onto one sub-tile. At column X, counted from the sub-tile's
/// middle, log2 alpha in its first row is c0 + c1 X + c2 X^2. From there to the second row it grows
/// by d0 + d1 X, and from row to row that growth itself grows by a constant: log2 of `bend` with
/// Rows::products, `bend` with Rows::exponents.
struct Staged {
  float4 shape;  // c0, c1, c2, d0
  float4 rest;   // d1, bend, red, green
  float blue;    // all colours without the background
};

/// The way in which pixels detect alpha < 1/255.
enum class Cut {
  flush,  ///< alphas are scaled so that 1/255 is the smallest normal float: smaller alphas become 0
  compare  ///< alphas are compared, which costs an instruction and is as exact as on the CPU
};

/// The way in which the alphas of a column's rows are computed.
enum class Rows {
  products,  ///< products of two exponentials; they underflow if a Gaussian is thinner than a pixel
  exponents  ///< an exponential each, which costs instructions
};

template <Cut kCut>
constexpr float kAlphaScale = kCut == Cut::flush ? 255 * 0x1p-126f : 1.0f;

/// The transmittance of an empty pixel, so that alpha times transmittance is the plain weight.
template <Cut kCut>
constexpr float kClear = kCut == Cut::flush ? 0x1p126f / 255 : 1.0f;

/// The state of one pixel during compositing. `red`, `green` and `blue` begin with the background,
/// which staged colours do not contain. Transmittance goes on falling after the pixel has stopped.
template <Cut kCut>
struct ColumnPixel {
  float transmittance;  ///< scaled by kClear
  float red, green, blue;

  __device__ bool is_live() const { return transmittance >= kTransmittanceMin * kClear<kCut>; }

  /// `alpha` is scaled by kAlphaScale. The Gaussian is skipped if alpha < 1/255, and the pixel
  /// stops if its transmittance falls below kTransmittanceMin.
  __device__ void add(float alpha, float4 rest, float more_blue) {
    if (kCut == Cut::compare && !(alpha >= kAlphaMin)) return;
    const float weight = mul_flush(alpha, transmittance);
    transmittance = fma_flush(weight, -kClear<kCut>, transmittance);
    if (!is_live()) return;
    red = fmaf(weight, rest.z, red);
    green = fmaf(weight, rest.w, green);
    blue = fmaf(weight, more_blue, blue);
  }
};

/// The pixels of a lane, from top to bottom. fmaf is explicit because compilers may not contract
/// (kernel/hd.h).
template <Cut kCut>
struct Column {
  float x;  // counted from the sub-tile's middle
  ColumnPixel<kCut> pixels[kPixels];

  __device__ bool any_live() const {
    bool any = false;
    for (const ColumnPixel<kCut>& pixel : pixels) any = any || pixel.is_live();
    return any;
  }

  /// kClamps: limits alpha to kAlphaMax, which few Gaussians exceed. `most_log2`: see
  /// BlendInput::most_log2_alpha, with Rows::exponents.
  template <bool kClamps, Rows kRows>
  __device__ void add(float4 shape, float4 rest, float more_blue, float most_log2) {
    static_assert(kPixels == 4);
    const float first = fmaf(fmaf(shape.z, x, shape.y), x, shape.x);
    const float growth = fmaf(rest.x, x, shape.w);
    float alphas[kPixels];
    if constexpr (kRows == Rows::products)
      multiply(exp2_flush(first), exp2_flush(growth), rest.y, alphas);
    else
      add_up(first, growth, rest.y, most_log2, alphas);
#pragma unroll
    for (int j = 0; j < kPixels; ++j) {
      if (kClamps) alphas[j] = fminf(alphas[j], kAlphaMax * kAlphaScale<kCut>);
      pixels[j].add(alphas[j], rest, more_blue);
    }
  }

 private:
  /// Rows::products (Turkowski, GPU Gems 3, chapter 40).
  static __device__ void multiply(float first, float growth1, float bend, float* alphas) {
    const float growth2 = mul_flush(growth1, bend), growth3 = mul_flush(growth2, bend);
    const float second = mul_flush(growth1, kAlphaScale<kCut>);
    const float third = mul_flush(second, growth2), fourth = mul_flush(third, growth3);
    alphas[0] = mul_flush(first, kAlphaScale<kCut>);
    alphas[1] = mul_flush(first, second);
    alphas[2] = mul_flush(first, third);
    alphas[3] = mul_flush(first, fourth);
  }

  /// Rows::exponents. Pixels are skipped if rounding broke the conic.
  static __device__ void add_up(float first, float growth, float bend, float most_log2,
                                float* alphas) {
#pragma unroll
    for (int j = 0; j < kPixels; ++j) {
      const auto row = static_cast<float>(j);
      const float log2_alpha = fmaf(row, growth, fmaf(0.5f * row * (row - 1), bend, first));
      const float valid = log2_alpha <= most_log2 ? log2_alpha : -INFINITY;
      alphas[j] = mul_flush(exp2_flush(valid), kAlphaScale<kCut>);
    }
  }
};

constexpr unsigned kLanes = kWarp / kSubTiles;  // of a sub-tile, a column of pixels each
static_assert(kLanes == kSubWidth && kPixels == kSubHeight);

constexpr unsigned kUnroll = 4;  // slots composited per loop iteration
constexpr unsigned kRing = 52;   // slots; with more, fewer warps fit into a multiprocessor
static_assert(kRing % kUnroll == 0 && kRing > kWarp);

/// The slots of one sub-tile, circular. A slot without a Gaussian has c0 = -inf, so alpha is 0.
struct Ring {
  float4 shape[kRing], rest[kRing];  // as in Staged
  float blue[kRing];
  float4 gap;  // the rings of a warp begin in different banks

  __device__ void store(unsigned slot, const Staged& staged) {
    shape[slot] = staged.shape;
    rest[slot] = staged.rest;
    blue[slot] = staged.blue;
  }
};
static_assert(sizeof(Ring) % 128 != 0 && sizeof(Ring) % 16 == 0);

/// A warp's rings. All its lanes call the functions together, with equal lengths.
template <bool kMaps>
struct Rings {
  Ring rings[kSubTiles];
  std::uint32_t places[kMaps ? kSubTiles : 1][kMaps ? kRing : 1];  // of the slots' list entries

  static __device__ unsigned wrapped(unsigned slot) { return slot < kRing ? slot : slot - kRing; }

  /// Empty slots are read too, so they must hold finite values.
  __device__ void clear() {
    constexpr unsigned kVectors = kSubTiles * (sizeof(Ring) / sizeof(float4));
    auto* const all = reinterpret_cast<float4*>(rings);
    for (unsigned i = lane_index(); i < kVectors; i += kWarp) all[i] = float4{0, 0, 0, 0};
    __syncwarp();
  }

  /// Empties the slots of this lane's sub-tile from `length` to `end`, counted from `head`.
  __device__ void pad(unsigned head, unsigned length, unsigned end) {
    const unsigned lane = lane_index();
#pragma unroll 1
    for (unsigned i = length + lane % kLanes; i < end; i += kLanes)
      rings[lane / kLanes].shape[wrapped(head + i)].x = -INFINITY;
  }
};

}  // namespace qs::cuda::fast
