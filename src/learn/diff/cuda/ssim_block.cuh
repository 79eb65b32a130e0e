// SPDX-License-Identifier: MIT
//
// SSIM's window over pictures, for kernels whose blocks have a rectangle of values each. The
// channels of a pixel are side by side, or every channel is a picture of its own.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>

#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/ssim.h"
#include "raster/scene/image_metrics.h"

namespace qs::cuda::diff {

inline constexpr int kSsimRow = 48;  ///< values in a row of a block
inline constexpr int kSsimSide = 16, kSsimHighSide = kSsimSide + 2 * kSsimRadius;  ///< rows

// A thread computes a run of neighbours of one channel, because they share most of their inputs:
// first kSsimAlong along a row, then kSsimDown down a column.
inline constexpr int kSsimAlong = 8, kSsimDown = 4;
inline constexpr unsigned kSsimBlock = kSsimRow * kSsimSide / kSsimDown;  ///< threads
static_assert(kSsimHighSide * kSsimRow / kSsimAlong <= int{kSsimBlock});

/// Pictures of one size as rows of values, with kChannels of a pixel side by side.
template <int kChannels>
struct SsimShape {
  static constexpr int kMargin = kSsimRadius * kChannels;
  static constexpr int kWideRow = kSsimRow + 2 * kMargin;  ///< with the values around them
  static_assert(kSsimRow % (kSsimAlong * kChannels) == 0);

  int row;                  ///< values in a row
  int height;               ///< rows
  int columns;              ///< blocks side by side
  int blocks_of_picture;    ///< blocks of one picture
  float window[kSsimSize];  ///< weights along one axis

  static SsimShape of_image(int width, int height) {
    constexpr int kWidth = kSsimRow / kChannels;
    const int across = (width + kWidth - 1) / kWidth;
    SsimShape shape{
        width * kChannels, height, across, across * ((height + kSsimSide - 1) / kSsimSide), {}};
    const auto weights = ssim_window();
    for (int k = 0; k < kSsimSize; ++k) assert(weights[k] == weights[kSsimSize - 1 - k]);
    std::copy(weights.begin(), weights.end(), shape.window);
    return shape;
  }

  /// Values of a picture.
  std::uint32_t count() const { return static_cast<std::uint32_t>(row * height); }

  /// The picture of the running block.
  __device__ int picture() const { return static_cast<int>(blockIdx.x) / blocks_of_picture; }
  // Of the first value of the running block.
  __device__ int left() const {
    return static_cast<int>(blockIdx.x) % blocks_of_picture % columns * kSsimRow;
  }
  __device__ int top() const {
    return static_cast<int>(blockIdx.x) % blocks_of_picture / columns * kSsimSide;
  }

  __device__ bool contains(int x, int y) const { return x >= 0 && x < row && y >= 0 && y < height; }
  __device__ std::uint32_t index(int x, int y) const {
    return static_cast<std::uint32_t>(y * row + x);
  }
};

/// Values of a block and the values around them that the window reaches, in shared memory. They are
/// zero outside of the picture. Rows have odd lengths, so that a column is in all memory banks.
template <int kChannels, int kFields, int kMoments>
struct Surroundings {
  using Shape = SsimShape<kChannels>;

  float values[kFields][kSsimHighSide][Shape::kWideRow + 1];
  float rows[kMoments][kSsimHighSide][kSsimRow + 1];  ///< moments, blurred along the rows

  /// Sets every value of every field f: value_at(f, x, y) of the picture. A barrier must follow.
  template <class ValueAt>
  __device__ void load(const Shape& shape, const ValueAt& value_at) {
    constexpr int kWide = Shape::kWideRow;
    for (int n = static_cast<int>(threadIdx.x); n < kSsimHighSide * kWide; n += int{kSsimBlock}) {
      const int x = shape.left() + n % kWide - Shape::kMargin;
      const int y = shape.top() + n / kWide - kSsimRadius;
      const bool inside = shape.contains(x, y);
      for (int f = 0; f < kFields; ++f)
        values[f][n / kWide][n % kWide] = inside ? value_at(f, x, y) : 0.0f;
    }
  }

  /// Convolves the moments with the window, for the thread's kSsimDown values. set(in, out)
  /// computes the moments of a value from its fields. The order of the sums is the CPU's. All
  /// threads call it.
  template <class Set>
  __device__ void blur(const Shape& shape, const Set& set, float (&sums)[kMoments][kSsimDown]) {
    __syncthreads();
    blur_along_rows(shape, set);
    __syncthreads();
    const int x = own_column(), top = own_top();
    clear(sums);
#pragma unroll
    for (int j = 0; j < kSsimDown + kSsimSize - 1; ++j) {
      float moments[kMoments];
#pragma unroll
      for (int m = 0; m < kMoments; ++m) moments[m] = rows[m][top + j][x];
      add_to_run(shape, j, moments, sums);
    }
  }

 private:
  static __device__ int own_column() { return static_cast<int>(threadIdx.x) % kSsimRow; }
  static __device__ int own_top() { return static_cast<int>(threadIdx.x) / kSsimRow * kSsimDown; }

  template <int kRun>
  static __device__ void clear(float (&sums)[kMoments][kRun]) {
#pragma unroll
    for (int m = 0; m < kMoments; ++m)
#pragma unroll
      for (int own = 0; own < kRun; ++own) sums[m][own] = 0;
  }

  /// Adds input j of a run to the sums that it belongs to.
  template <int kRun>
  static __device__ void add_to_run(const Shape& shape, int j, const float (&moments)[kMoments],
                                    float (&sums)[kMoments][kRun]) {
#pragma unroll
    for (int own = 0; own < kRun; ++own) {
      const int k = j - own;
      if (k < 0 || k >= kSsimSize) continue;
      // The window is symmetric, so a product with a weight serves two sums.
      const float weight = shape.window[k <= kSsimRadius ? k : kSsimSize - 1 - k];
#pragma unroll
      for (int m = 0; m < kMoments; ++m) sums[m][own] += weight * moments[m];
    }
  }

  template <class Set>
  __device__ void blur_along_rows(const Shape& shape, const Set& set) {
    const int n = static_cast<int>(threadIdx.x);
    if (n >= kSsimHighSide * kSsimRow / kSsimAlong) return;
    const int y = n % kSsimHighSide, run = n / kSsimHighSide;
    const int begin = run / kChannels * kSsimAlong * kChannels + run % kChannels;
    float sums[kMoments][kSsimAlong];
    clear(sums);
#pragma unroll
    for (int j = 0; j < kSsimAlong + kSsimSize - 1; ++j) {
      float in[kFields], moments[kMoments];
#pragma unroll
      for (int f = 0; f < kFields; ++f) in[f] = values[f][y][begin + j * kChannels];
      set(in, moments);
      add_to_run(shape, j, moments, sums);
    }
#pragma unroll
    for (int m = 0; m < kMoments; ++m)
#pragma unroll
      for (int own = 0; own < kSsimAlong; ++own) rows[m][y][begin + own * kChannels] = sums[m][own];
  }
};

/// The moments of the values a and b.
struct SsimMoments {
  __device__ void operator()(const float (&in)[2], float (&out)[5]) const {
    const float a = in[0], b = in[1];
    out[0] = a;
    out[1] = b;
    out[2] = a * a;
    out[3] = b * b;
    out[4] = a * b;
  }
};

/// Three fields as they are.
struct SameFields {
  __device__ void operator()(const float (&in)[3], float (&out)[3]) const {
    for (int f = 0; f < 3; ++f) out[f] = in[f];
  }
};

/// SSIM of the moments of a thread's value.
__device__ inline Similarity<float> similarity_of(const float (&moments)[5][kSsimDown], int own) {
  return Similarity<float>::of(moments[0][own], moments[1][own], moments[2][own], moments[3][own],
                               moments[4][own]);
}

/// Calls visit(k, x, y) for the thread's values inside the picture; k counts them.
template <int kChannels, class Visit>
__device__ void for_own_values(const SsimShape<kChannels>& shape, const Visit& visit) {
  const int n = static_cast<int>(threadIdx.x);
#pragma unroll
  for (int own = 0; own < kSsimDown; ++own) {
    const int x = shape.left() + n % kSsimRow, y = shape.top() + n / kSsimRow * kSsimDown + own;
    if (shape.contains(x, y)) visit(own, x, y);
  }
}

}  // namespace qs::cuda::diff
