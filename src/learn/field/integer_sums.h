// SPDX-License-Identifier: MIT
//
// Arrays of sums of derivatives, see learn/gradient/integer_sum.h. They do not depend on the order
// in which threads add.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "learn/gradient/integer_sum.h"

namespace qs {

class IntegerSums {
 public:
  /// Sets all sums to 0.
  void reset(std::size_t values) { sums_.assign(values, 0); }

  /// Threads may add at the same time.
  template <class Real>
  void add(std::size_t at, Real by) {
    std::atomic_ref(sums_[at]).fetch_add(sum_units(by), std::memory_order_relaxed);
  }
  double sum(std::size_t at) const { return static_cast<double>(sums_[at]) * kSumUnit; }
  std::size_t size() const { return sums_.size(); }

 private:
  std::vector<std::int64_t> sums_;
};

}  // namespace qs
