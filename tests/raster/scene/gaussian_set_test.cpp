// SPDX-License-Identifier: MIT
//
// Sets of Gaussians against std::vector<bool>, at the sizes at which words and bytes begin.
#include "raster/scene/gaussian_set.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/pool.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::ElementsAreArray;

constexpr std::size_t kSizes[] = {0, 1, 7, 8, 63, 64, 65, 1000};

std::vector<bool> random_bits(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<bool> bits(size);
  for (std::size_t i = 0; i < size; ++i) bits[i] = random() % 3 == 0;
  return bits;
}

GaussianSet set_of(const std::vector<bool>& bits) {
  return GaussianSet::where(bits.size(), pool(2), [&](std::size_t i) { return bits[i]; });
}

TEST(GaussianSets, combine_as_lists_of_truths_do) {
  for (const std::size_t size : kSizes) {
    SCOPED_TRACE(size);
    const std::vector<bool> a = random_bits(size, 1), b = random_bits(size, 2);
    GaussianSet both = set_of(a), any = set_of(a), one = set_of(a), less = set_of(a);
    both &= set_of(b), any |= set_of(b), one ^= set_of(b), less -= set_of(b);
    const GaussianSet others = set_of(a).complement();
    std::size_t count = 0;
    for (std::size_t i = 0; i < size; ++i) {
      EXPECT_EQ(both[i], a[i] && b[i]);
      EXPECT_EQ(any[i], a[i] || b[i]);
      EXPECT_EQ(one[i], a[i] != b[i]);
      EXPECT_EQ(less[i], a[i] && !b[i]);
      EXPECT_EQ(others[i], !a[i]);
      count += a[i];
    }
    EXPECT_EQ(set_of(a).count(), count);
    EXPECT_EQ(others.count(), size - count);
    EXPECT_EQ(others.complement(), set_of(a));
    EXPECT_EQ(set_of(a).empty(), count == 0);
  }
}

TEST(GaussianSets, have_bytes_runs_and_numbers_of_their_bits) {
  GaussianSet set(20);
  for (const std::size_t i : {0, 1, 2, 9, 18, 19}) set.add(i);
  set.add_atomically(9);
  EXPECT_THAT(set.bytes(), ElementsAre(std::byte{7}, std::byte{2}, std::byte{12}));
  EXPECT_THAT(set.numbers(), ElementsAre(0u, 1u, 2u, 9u, 18u, 19u));
  EXPECT_THAT(set.runs(), ElementsAre(GaussianRun{0, 3}, GaussianRun{9, 1}, GaussianRun{18, 2}));
  set.toggle(9);
  EXPECT_FALSE(set[9]);
  EXPECT_THAT(GaussianSet(0).runs(), ElementsAre());
  for (const std::size_t size : kSizes)
    EXPECT_THAT(GaussianSet(size).complement().runs(),
                ElementsAreArray(std::vector<GaussianRun>(size > 0, GaussianRun{0, size})));
}

TEST(GaussianSets, are_equal_for_any_number_of_threads) {
  const auto odd = [](std::size_t i) { return i * i % 7 == 2; };
  EXPECT_EQ(GaussianSet::where(300'001, pool(1), odd), GaussianSet::where(300'001, pool(5), odd));
}

}  // namespace
}  // namespace qs::test
