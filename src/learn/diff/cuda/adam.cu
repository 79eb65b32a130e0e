// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/adam.h"
#include "learn/diff/cuda/frame_blocks.cuh"
#include "raster/cuda/common/check.cuh"

namespace qs::cuda::diff {
namespace {

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
  AdamArrays joined = arrays;
  join_last_dimensions(joined);
  for_each_item("adam", count, stream_of(queue), [=] __device__(std::size_t rest) {
    std::size_t index[4];
    for (int i = 3; i > 0; --i) {
      const std::size_t size = joined.sizes[i];
      index[i] = size == 1 ? 0 : rest % size;
      rest = size == 1 ? rest : rest / size;
    }
    index[0] = rest;
    if (joined.visible != nullptr &&
        joined.visible[static_cast<std::ptrdiff_t>(rest) * joined.visible_stride] == 0)
      return;
    qs::adam(rule, step, rate, joined.gradients.at(index), joined.values.at(index),
             joined.first.at(index), joined.second.at(index));
  });
}

}  // namespace qs::cuda::diff
