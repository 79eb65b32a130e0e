// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/adam.h"
#include "learn/diff/cuda/frame_blocks.cuh"
#include "raster/cuda/common/check.cuh"

namespace qs::cuda::diff {
namespace {

/// A thread for each value.
__global__ void step_values(AdamArrays arrays, AdamRule rule, AdamStep step, float rate) {
  std::size_t rest = std::size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  std::size_t index[4];
  for (int i = 3; i > 0; --i) {
    const std::size_t size = arrays.sizes[i];
    index[i] = size == 1 ? 0 : rest % size;
    rest = size == 1 ? rest : rest / size;
  }
  index[0] = rest;
  if (rest >= arrays.sizes[0]) return;
  if (arrays.visible != nullptr &&
      arrays.visible[static_cast<std::ptrdiff_t>(rest) * arrays.visible_stride] == 0)
    return;
  qs::adam(rule, step, rate, arrays.gradients.at(index), arrays.values.at(index),
           arrays.first.at(index), arrays.second.at(index));
}

/// Makes one dimension of dimensions whose elements follow each other in all arrays, but for the
/// rows, so that threads divide less.
void join_last_dimensions(AdamArrays& arrays) {
  std::ptrdiff_t* const all[] = {arrays.gradients.strides, arrays.values.strides,
                                 arrays.first.strides, arrays.second.strides};
  for (int i = 2; i > 0; --i) {
    const auto last = static_cast<std::ptrdiff_t>(arrays.sizes[i + 1]);
    if (last == 1) continue;
    for (const std::ptrdiff_t* const strides : all)
      if (strides[i] != strides[i + 1] * last) return;
    arrays.sizes[i] *= arrays.sizes[i + 1];
    arrays.sizes[i + 1] = 1;
    for (std::ptrdiff_t* const strides : all) strides[i] = strides[i + 1];
  }
}

}  // namespace

void adam(const AdamArrays& arrays, const AdamRule& rule, const AdamStep& step, float rate,
          const Queue& queue) {
  std::size_t count = 1;
  for (const std::size_t size : arrays.sizes) count *= size;
  if (count == 0) return;
  AdamArrays joined = arrays;
  join_last_dimensions(joined);
  launch("adam", step_values, blocks_for(count), stream_of(queue), joined, rule, step, rate);
}

}  // namespace qs::cuda::diff
