// SPDX-License-Identifier: MIT
#include "raster/cpu/common/sort.h"

#include <array>
#include <bit>
#include <utility>

namespace qs::cpu {

// A stable least-significant-digit radix sort of the depths' bits: positive floats order like
// unsigned integers. Slots enter by ascending index in the cloud, so equal depths keep that order.
void sort(const FrameContext& frame, const VisibleSlots& visible, DepthOrder& order) {
  constexpr int kDigitBits = 11, kDigits = 3;
  constexpr std::uint32_t kBuckets = 1u << kDigitBits;
  order.keys.resize(visible.count);
  order.slots.resize(visible.count);
  order.other_keys.resize(visible.count);
  order.other_slots.resize(visible.count);

  std::array<std::array<std::uint32_t, kBuckets>, kDigits> offsets{};
  const auto digit = [](std::uint32_t key, int pass) {
    return (key >> (pass * kDigitBits)) & (kBuckets - 1);
  };
  // Gather the keys and count the digits of all passes.
  std::size_t at = 0;
  visible.for_each([&](std::uint32_t slot) {
    const auto key = std::bit_cast<std::uint32_t>(visible.depths[slot]);
    order.keys[at] = key;
    order.slots[at] = slot;
    for (int pass = 0; pass < kDigits; ++pass)
      ++offsets[static_cast<std::size_t>(pass)][digit(key, pass)];
    ++at;
  });
  // Move the items, one digit per pass.
  for (int pass = 0; pass < kDigits; ++pass) {
    if (frame.stop.stop_requested()) throw Cancelled{};
    auto& offset = offsets[static_cast<std::size_t>(pass)];
    std::uint32_t sum = 0;
    for (std::uint32_t& bucket : offset) sum += std::exchange(bucket, sum);
    for (std::size_t i = 0; i < order.keys.size(); ++i) {
      const std::uint32_t to = offset[digit(order.keys[i], pass)]++;
      order.other_keys[to] = order.keys[i];
      order.other_slots[to] = order.slots[i];
    }
    order.keys.swap(order.other_keys);
    order.slots.swap(order.other_slots);
  }
}

}  // namespace qs::cpu
