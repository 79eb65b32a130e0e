// SPDX-License-Identifier: MIT
//
// A stable radix sort of 32-bit keys by all threads: what orders the scene in space and every frame
// in depth.
#pragma once

#include <cstdint>
#include <stop_token>

#include "raster/base/parallel.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::cpu::fast {

/// Keys with a value each, and the memory that sorting them takes.
struct SortItems {
  Array<std::uint32_t> keys, values;

  Array<std::uint32_t> other_keys, other_values;  ///< scratch
  Array<std::uint32_t> offsets;                   ///< scratch, [segment][digit]

  void resize(std::size_t count) {
    for (auto* array : {&keys, &values, &other_keys, &other_values}) array->resize(count);
  }
};

/// Range of keys, both included; as it stands that of none.
struct KeyRange {
  std::uint32_t low = ~0u, high = 0;

  void include(KeyRange other) {
    low = other.low < low ? other.low : low;
    high = other.high > high ? other.high : high;
  }
  void include(std::uint32_t key) { include({key, key}); }
};

/// Orders `items` by ascending key; values of equal keys keep their order. All keys lie in `range`:
/// the narrower, the quicker. The result does not depend on the number of threads. Throws Cancelled
/// when `stop` is triggered.
void radix_sort(SortItems& items, KeyRange range, ThreadPool& pool,
                const std::stop_token& stop = {});

}  // namespace qs::cpu::fast
