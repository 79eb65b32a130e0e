// SPDX-License-Identifier: MIT
//
// A stable radix sort of 32-bit keys on all threads. It orders the scene in space and every frame
// by depth.
#pragma once

#include <cstdint>
#include <stop_token>

#include "base/parallel.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Keys with one value each, and the sort's buffers.
struct SortItems {
  Array<std::uint32_t> keys, values;

  Array<std::uint32_t> other_keys, other_values;  ///< scratch
  Array<std::uint32_t> offsets;                   ///< scratch, [segment][digit]

  void resize(std::size_t count) {
    for (auto* array : {&keys, &values, &other_keys, &other_values}) array->resize(count);
  }
};

/// Range of keys, both ends included; empty by default.
struct KeyRange {
  std::uint32_t low = ~0u, high = 0;

  void include(KeyRange other) {
    low = other.low < low ? other.low : low;
    high = other.high > high ? other.high : high;
  }
  void include(std::uint32_t key) { include({key, key}); }
};

/// Sorts `items` by ascending key; values of equal keys keep their order. All keys must be in
/// `range`; a narrow range is faster. The result does not depend on the number of threads. Throws
/// Cancelled.
void radix_sort(SortItems& items, KeyRange range, ThreadPool& pool,
                const std::stop_token& stop = {});

}  // namespace qs
