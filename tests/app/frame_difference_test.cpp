// SPDX-License-Identifier: MIT
#include "app/inspect/frame_difference.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/inspect/variant.h"

namespace qs {
namespace {

using testing::ElementsAre;

TEST(PixelDifference, names_the_first_of_the_farthest_pixels_and_leaves_the_rest_out) {
  constexpr int kWidth = 4, kHeight = 3;
  std::vector<std::uint8_t> a(4 * kWidth * kHeight, 100), b = a;
  const auto value = [&](int x, int y, int c) -> std::uint8_t& {
    return b[static_cast<std::size_t>(4 * (y * kWidth + x) + c)];
  };
  const PixelBox all{0, 0, kWidth, kHeight};
  EXPECT_EQ(pixel_difference(a, b, kWidth, all).pixels, 0u);
  EXPECT_TRUE(std::isinf(pixel_difference(a, b, kWidth, all).psnr));
  EXPECT_EQ(pixel_difference(a, b, kWidth, all).farthest, glm::ivec2(-1));

  value(3, 0, 1) = 97;
  value(1, 2, 0) = 105;
  value(2, 2, 2) = 95;
  value(0, 1, 3) = 0;  // opacity is no colour
  const PixelDifference whole = pixel_difference(a, b, kWidth, all);
  EXPECT_EQ(whole.largest, 5);
  EXPECT_EQ(whole.farthest, glm::ivec2(1, 2));
  EXPECT_EQ(whole.pixels, 3u);
  EXPECT_NEAR(whole.psnr, 10 * std::log10(255.0 * 255.0 / ((9.0 + 25 + 25) / (3 * 12))), 1e-12);

  const PixelDifference row = pixel_difference(a, b, kWidth, {0, 0, kWidth, 1});
  EXPECT_EQ(row.largest, 3);
  EXPECT_EQ(row.pixels, 1u);
  EXPECT_NEAR(row.psnr, 10 * std::log10(255.0 * 255.0 / (9.0 / (3 * 4))), 1e-12);
}

TEST(PairDifference, has_signs_and_a_total) {
  const std::vector<std::uint32_t> a = {5, 0, 7}, b = {2, 4, 7};
  const PairDifference difference = pair_difference({3, 1, 16}, a, b);
  EXPECT_THAT(difference.values, ElementsAre(3, -4, 0));
  EXPECT_EQ(difference.total, -1);
}

TEST(Variant, is_told_with_no_more_than_what_differs) {
  const CullMode exact = find_culler("exact"), adr = find_culler("adr");
  const Variant cpu{exact, Pipeline::fast, Backend::cpu};
  const Variant gpu{adr, Pipeline::fast, Backend::cuda};
  const Variant classic{adr, Pipeline::classic, Backend::cuda};
  const Variant reference{kReferenceMode, Pipeline::fast, Backend::cpu};
  EXPECT_EQ(full_name(cpu), "exact, cpu");
  EXPECT_EQ(full_name(classic), "adr, cuda classic");
  EXPECT_EQ(full_name(reference), "reference");
  EXPECT_EQ(name_beside(cpu, {adr, Pipeline::classic, Backend::cpu}), "exact");
  EXPECT_EQ(name_beside(gpu, classic), "adr, cuda fast");
  EXPECT_EQ(name_beside(cpu, gpu), "exact, cpu");
  EXPECT_EQ(name_beside(gpu, reference), "adr");
  EXPECT_EQ(name_beside(reference, gpu), "reference");
  EXPECT_EQ(find_variant("exact, cpu", gpu), cpu);
  EXPECT_EQ(find_variant("reference", cpu), reference);
  EXPECT_EQ(find_variant("adr", {exact, Pipeline::classic, Backend::cuda}), classic);
  EXPECT_FALSE(find_variant("adr, somewhere", cpu));
}

}  // namespace
}  // namespace qs
