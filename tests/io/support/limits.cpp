// SPDX-License-Identifier: MIT
#include "io/support/limits.h"

#include <ctime>

#include <gtest/gtest.h>

namespace qs::test {
namespace {

constexpr std::size_t kMaxHeapBytes = std::size_t{1} << 30;
// Of processor time, which other programs do not take. ThreadSanitizer takes 5 to 15 times as much.
#if defined(__SANITIZE_THREAD__)
constexpr double kMaxSeconds = 75;
#else
constexpr double kMaxSeconds = 5;
#endif

}  // namespace

void expect_within_limits(const std::function<std::size_t()>& read) {
  const HeapPeak heap;
  const std::clock_t start = std::clock();
  const std::size_t decoded = read();
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, kMaxSeconds);
  EXPECT_LE(heap.bytes(), kMaxHeapBytes + decoded);
}

std::size_t bytes_of(const GaussianCloud& cloud) {
  const auto bytes = [](const auto& array) { return array.capacity() * sizeof array[0]; };
  return bytes(cloud.positions) + bytes(cloud.log_scales) + bytes(cloud.rotations) +
         bytes(cloud.opacity_logits) + bytes(cloud.sh);
}

}  // namespace qs::test
