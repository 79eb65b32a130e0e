// SPDX-License-Identifier: MIT
//
// Checks that the measurement of the heap works; otherwise Damage.* and Corpus.* could never fail.
#include "io/support/limits.h"

#include <cstdlib>
#include <thread>

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include "io/picture/webp_image.h"
#include "support/corpus.h"

namespace qs::test {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

// Prevents the compiler from removing unused allocations.
template <class T>
T* used(T* memory) {
  asm volatile("" : "+r"(memory) : : "memory");
  return memory;
}

TEST(Limits, heap_of_new_and_malloc_is_counted_until_it_is_freed) {
  const HeapPeak peak;
  EXPECT_LT(peak.bytes(), kMiB);
  char* const one = used(new char[3 * kMiB]);
  EXPECT_GE(peak.bytes(), 3 * kMiB);
  void* const two = used(std::malloc(2 * kMiB));
  EXPECT_GE(peak.bytes(), 5 * kMiB);
  delete[] one;
  std::free(two);
  std::free(used(std::malloc(4 * kMiB)));
  EXPECT_LT(peak.bytes(), 6 * kMiB);
}

TEST(Limits, grown_and_aligned_memory_is_counted) {
  const HeapPeak peak;
  std::free(used(std::realloc(used(std::malloc(kMiB)), 7 * kMiB)));
  EXPECT_GE(peak.bytes(), 7 * kMiB);
  std::free(used(std::aligned_alloc(4096, 9 * kMiB)));
#if !defined(__SANITIZE_THREAD__)  // its runtime does not report aligned memory
  EXPECT_GE(peak.bytes(), 9 * kMiB);
#endif
  EXPECT_LT(peak.bytes(), 10 * kMiB);
}

TEST(Limits, heap_of_other_threads_is_counted) {
  const HeapPeak peak;
  std::jthread([] { std::free(used(std::malloc(5 * kMiB))); }).join();
  EXPECT_GE(peak.bytes(), 5 * kMiB);
}

TEST(Limits, heap_of_libraries_is_counted) {
  const auto picture = file_bytes(committed_corpus() / "valid/sog_v1_folder/sh0.webp");
  const HeapPeak peak;
  const std::size_t pixels = decode_webp(picture, "picture").size();
  EXPECT_GT(peak.bytes(), pixels + pixels / 2);  // libwebp holds a second copy of the pixels
}

TEST(Limits, more_than_a_gibibyte_beyond_the_scene_fails) {
  expect_within_limits([] {
    std::free(used(std::malloc(1023 * kMiB)));  // never touched: costs nothing here
    return std::size_t{0};
  });
  expect_within_limits([] {
    std::free(used(std::malloc(1500 * kMiB)));
    return 500 * kMiB;
  });
  EXPECT_NONFATAL_FAILURE(expect_within_limits([] {
                            std::free(used(std::malloc(1025 * kMiB)));
                            return std::size_t{0};
                          }),
                          "heap.bytes()");
}

}  // namespace
}  // namespace qs::test
