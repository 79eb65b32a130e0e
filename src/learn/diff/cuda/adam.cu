// SPDX-License-Identifier: MIT
#include <algorithm>

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

/// Arrays of a launch, a kernel parameter. Item i belongs to the last array whose `first` is not
/// above i.
struct Batch {
  static constexpr unsigned kMost = 8;

  AdamOrder orders[kMost];
  std::size_t first[kMost];
  unsigned count = 0;
  std::size_t items = 0;

  void add(const AdamOrder& order) {
    std::size_t values = 1;
    for (const std::size_t size : order.arrays.sizes) values *= size;
    orders[count] = order;
    join_last_dimensions(orders[count].arrays);
    first[count++] = items;
    items += values;
  }

  __device__ void step(std::size_t item) const {
    unsigned k = 0;
    while (k + 1 < count && first[k + 1] <= item) ++k;
    const AdamArrays& arrays = orders[k].arrays;
    std::size_t rest = item - first[k];
    std::size_t index[4];
    for (int i = 3; i > 0; --i) {
      const std::size_t size = arrays.sizes[i];
      index[i] = size == 1 ? 0 : rest % size;
      rest = size == 1 ? rest : rest / size;
    }
    index[0] = rest;
    if (arrays.visible != nullptr &&
        arrays.visible[static_cast<std::ptrdiff_t>(rest) * arrays.visible_stride] == 0)
      return;
    qs::adam(orders[k].rule, orders[k].step, orders[k].rate, arrays.gradients.at(index),
             arrays.values.at(index), arrays.first.at(index), arrays.second.at(index));
  }
};

}  // namespace

void adam(std::span<const AdamOrder> orders, const Queue& queue) {
  while (!orders.empty()) {
    Batch batch;
    const auto size = std::min<std::size_t>(orders.size(), Batch::kMost);
    for (const AdamOrder& order : orders.first(size)) batch.add(order);
    for_each_item("adam", batch.items, stream_of(queue),
                  [=] __device__(std::size_t i) { batch.step(i); });
    orders = orders.subspan(size);
  }
}

}  // namespace qs::cuda::diff
