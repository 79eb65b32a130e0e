// SPDX-License-Identifier: MIT
#include <bit>

#include "raster/cpu/common/tile_lists.h"

namespace qs::cpu {

// Positive floats order like the unsigned integers of their bits. Slots enter by ascending index in
// the cloud, and the sort is stable, so equal depths keep that order.
void sort(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order) {
  order.resize(visible.count);
  KeyRange range;
  std::size_t at = 0;
  visible.for_each([&](std::uint32_t slot) {
    order.keys[at] = std::bit_cast<std::uint32_t>(visible.depths[slot]);
    order.values[at] = slot;
    range.include(order.keys[at++]);
  });
  radix_sort(order, range, frame.pool, frame.stop);
}

}  // namespace qs::cpu
