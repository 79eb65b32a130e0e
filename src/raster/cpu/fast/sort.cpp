// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/sort.h"

#include <algorithm>
#include <utility>

namespace qs::cpu::fast {
namespace {

/// Sorts runs of equal depth by index in the cloud, because the radix sort left them in order of
/// slots, which is spatial. Ties are found without branches and their indices prefetched.
void order_ties(const VisibleSlots& visible, SortItems& items) {
  constexpr std::size_t kBatch = 512;
  const std::uint32_t* keys = items.keys.data();
  const std::uint32_t* gaussians = visible.gaussians.data();
  const std::size_t size = items.keys.size();
  const auto earlier = [&](std::uint32_t a, std::uint32_t b) {
    return gaussians[a] < gaussians[b];
  };
  for (std::size_t begin = 0; begin + 1 < size; begin += kBatch) {
    // Find the items that have the depth of the next item.
    std::size_t ties[kBatch], count = 0;
    const std::size_t end = std::min(begin + kBatch, size - 1);
    for (std::size_t i = begin; i < end; ++i) {
      ties[count] = i;
      count += static_cast<std::size_t>(keys[i] == keys[i + 1]);
    }
    // Keep the first item of each run.
    std::size_t runs = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = ties[k];
      if (i > 0 && keys[i - 1] == keys[i]) continue;
      __builtin_prefetch(gaussians + items.values[i]);
      __builtin_prefetch(gaussians + items.values[i + 1]);
      ties[runs++] = i;
    }
    // Sort the runs.
    for (std::size_t k = 0; k < runs; ++k) {
      const std::size_t i = ties[k];
      std::size_t length = 2;
      while (i + length < size && keys[i + length] == keys[i]) ++length;
      std::uint32_t* slots = &items.values[i];
      if (length > 2) {
        std::sort(slots, slots + length, earlier);
      } else if (earlier(slots[1], slots[0])) {
        std::swap(slots[0], slots[1]);
      }
    }
  }
}

}  // namespace

// Depths are positive floats; their bits order like unsigned integers.
void sort(const FrameContext& frame, const FastVisible& visible, Bands& bands) {
  find_bands(frame, visible, bands);
  frame.for_chunks(bands.size(), 1, [&](std::size_t i, std::size_t, int) {
    Band& band = *bands[i];
    const KeyRange range = band.gather(visible);
    radix_sort(band.items, range, band.alone, frame.stop);
    order_ties(visible, band.items);
  });
}

}  // namespace qs::cpu::fast
