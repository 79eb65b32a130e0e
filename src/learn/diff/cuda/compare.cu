// SPDX-License-Identifier: MIT
#include <algorithm>
#include <vector>

#include "learn/diff/cuda/compare.h"
#include "learn/diff/cuda/device.h"
#include "learn/diff/cuda/frame_blocks.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/ssim.h"

namespace qs::cuda::diff {
namespace {

constexpr int kOwnPixels = 16;                             // of a block, along one axis
constexpr int kReadPixels = kOwnPixels + 2 * kSsimRadius;  // with pixels that windows reach
static_assert(kOwnPixels * kOwnPixels == kThreads);

/// A kernel parameter.
struct ComparedWindow {
  GivenPictures in;
  double weights[kSsimSize];
  bool with_ssim;

  __device__ bool counts(int x, int y) const {
    if (x < 0 || x >= in.width || y < 0 || y >= in.height) return false;
    return in.mask.data == nullptr || static_cast<const std::uint8_t*>(
                                          in.mask.data)[y * in.mask.down + x * in.mask.right] != 0;
  }
  static __device__ float value_of(const GivenPicture& from, int x, int y, int channel) {
    const std::ptrdiff_t at = y * from.down + x * from.right + channel * from.deep;
    if (from.element_bytes == 1) return static_cast<const std::uint8_t*>(from.data)[at] / 255.0f;
    const float value = from.element_bytes == 4
                            ? static_cast<const float*>(from.data)[at]
                            : static_cast<float>(static_cast<const double*>(from.data)[at]);
    return fminf(fmaxf(0.0f, value), 1.0f);  // NaN becomes 0
  }
};

/// As to_8bit() of image.h, of a value of 0..1.
__device__ inline int bits8_of(float value) { return static_cast<int>(255.0f * value + 0.5f); }

/// One block per 16x16 pixels with a thread each.
__global__ void __launch_bounds__(kThreads)
    sum_comparison(ComparedWindow window, unsigned columns, ComparisonSums* sums) {
  __shared__ float values[2][kReadPixels][kReadPixels];
  __shared__ SsimMeans rows[kReadPixels][kOwnPixels];  // along the rows
  const GivenPictures& in = window.in;
  const int left = static_cast<int>(blockIdx.x % columns) * kOwnPixels;
  const int top = static_cast<int>(blockIdx.x / columns) * kOwnPixels;
  const int thread = static_cast<int>(threadIdx.x), column = thread % kOwnPixels,
            row = thread / kOwnPixels;
  const int x = left + column, y = top + row;
  const bool counts = window.counts(x, y);
  const bool is_inside = counts && x >= in.margin && x + in.margin < in.width && y >= in.margin &&
                         y + in.margin < in.height;
  double squared = 0, ssim = 0;
  unsigned squared_8bit = 0;
  for (int channel = 0; channel < 3; ++channel) {
    __syncthreads();
    for (int n = thread; n < kReadPixels * kReadPixels; n += int{kThreads}) {
      const int at_x = left + n % kReadPixels - kSsimRadius,
                at_y = top + n / kReadPixels - kSsimRadius;
      const bool exists = window.counts(at_x, at_y);
      for (int f = 0; f < 2; ++f) {
        const GivenPicture& from = f == 0 ? in.a : in.b;
        values[f][n / kReadPixels][n % kReadPixels] =
            exists ? window.value_of(from, at_x, at_y, channel) : 0;
      }
    }
    __syncthreads();
    const float a = values[0][row + kSsimRadius][column + kSsimRadius];
    const float b = values[1][row + kSsimRadius][column + kSsimRadius];
    const double difference = static_cast<double>(a) - static_cast<double>(b);
    const int rounded = bits8_of(a) - bits8_of(b);
    squared += difference * difference;
    squared_8bit += static_cast<unsigned>(rounded * rounded);
    if (!window.with_ssim) continue;
    for (int n = thread; n < kReadPixels * kOwnPixels; n += int{kThreads}) {
      SsimMeans means{};
      for (int k = 0; k < kSsimSize; ++k)
        means.add(
            window.weights[k],
            SsimMeans::of(static_cast<double>(values[0][n / kOwnPixels][n % kOwnPixels + k]),
                          static_cast<double>(values[1][n / kOwnPixels][n % kOwnPixels + k])));
      rows[n / kOwnPixels][n % kOwnPixels] = means;
    }
    __syncthreads();
    if (!is_inside) continue;
    SsimMeans means{};
    for (int k = 0; k < kSsimSize; ++k) means.add(window.weights[k], rows[row + k][column]);
    ssim += means.similarity();
  }
  const ComparisonSums total{sum_of_block<kThreads>(squared).total,
                             sum_of_block<kThreads>(ssim).total,
                             sum_of_block<kThreads>(squared_8bit).total,
                             3 * sum_of_block<kThreads>(counts ? 1u : 0u).total,
                             3 * sum_of_block<kThreads>(is_inside ? 1u : 0u).total};
  if (threadIdx.x == 0) sums[blockIdx.x] = total;
}

unsigned blocks_along(int pixels) {
  return static_cast<unsigned>((pixels + kOwnPixels - 1) / kOwnPixels);
}
unsigned comparison_blocks(const GivenPictures& pictures) {
  return blocks_along(pictures.width) * blocks_along(pictures.height);
}

}  // namespace

std::size_t bytes_to_compare(const GivenPictures& pictures) {
  return comparison_blocks(pictures) * sizeof(ComparisonSums);
}

ComparisonSums compare(const GivenPictures& pictures, bool with_ssim, const Queue& queue,
                       void* scratch) {
  queue.throw_if_cancelled();
  ComparedWindow window{pictures, {}, with_ssim};
  const auto weights = ssim_window();
  std::copy(weights.begin(), weights.end(), window.weights);
  auto* const sums = static_cast<ComparisonSums*>(scratch);
  launch("sum_comparison", sum_comparison, comparison_blocks(pictures), stream_of(queue), window,
         blocks_along(pictures.width), sums);
  std::vector<ComparisonSums> of_blocks(comparison_blocks(pictures));
  copy_from_gpu(of_blocks.data(), sums, bytes_to_compare(pictures), queue);
  ComparisonSums total{};
  for (const ComparisonSums& each : of_blocks) {
    total.squared += each.squared;
    total.ssim += each.ssim;
    total.squared_8bit += each.squared_8bit;
    total.values += each.values;
    total.values_inside += each.values_inside;
  }
  return total;
}

}  // namespace qs::cuda::diff
