// SPDX-License-Identifier: MIT
//
// Pictures of alpha and depth: their scales, colours and files.
#include "app/picture/value_map.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/picture/palette.h"
#include "io/bytes/json_text.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::error_of;
using testing::ElementsAre;
using testing::HasSubstr;

ValueMap depths(std::vector<float> values) {
  const int width = static_cast<int>(values.size());
  const ValueScale scale = scale_for(Quantity::depth, values);
  return {Quantity::depth, width, 1, std::move(values), scale};
}

TEST(ValueScale, has_round_ends_around_the_depths_and_ignores_pixels_without) {
  const ValueScale scale = scale_for(Quantity::depth, std::vector<float>{0, 1.53f, 3.9f, 0, 2});
  EXPECT_FLOAT_EQ(scale.low, 1.5f);
  EXPECT_FLOAT_EQ(scale.high, 4);
  EXPECT_FLOAT_EQ(scale.step, 0.5f);
  EXPECT_EQ(scale.text_of_ends(), "1.5 to 4.0");
  const std::vector<float> ticks = scale.ticks();
  ASSERT_EQ(ticks.size(), 6u);
  EXPECT_FLOAT_EQ(ticks[3], 3);
}

TEST(ValueScale, contains_every_depth_of_small_maps_in_at_most_eight_steps) {
  for (const float size : {1e-3f, 0.7f, 12.0f, 4e5f}) {
    for (int i = 0; i < 50; ++i) {
      const float least = size * (0.1f + 0.037f * static_cast<float>(i)), most = least + size;
      const ValueScale scale = scale_for(Quantity::depth, std::vector<float>{most, least});
      EXPECT_LE(scale.low, least * 1.0001f);
      EXPECT_GE(scale.high, most * 0.9999f);
      EXPECT_LE(std::lround((scale.high - scale.low) / scale.step), 8);
      EXPECT_GE(std::lround((scale.high - scale.low) / scale.step), 3);
    }
  }
}

TEST(ValueScale, of_one_depth_of_none_and_of_alpha_exists) {
  const ValueScale one = scale_for(Quantity::depth, std::vector<float>{7, 7});
  EXPECT_LE(one.low, 7);
  EXPECT_GT(one.high, one.low);
  const ValueScale none = scale_for(Quantity::depth, std::vector<float>{0, 0});
  EXPECT_GT(none.high, none.low);
  const ValueScale alpha = scale_for(Quantity::alpha, std::vector<float>{0.3f});
  EXPECT_EQ(alpha.low, 0);
  EXPECT_EQ(alpha.high, 1);
}

TEST(ValueMap, colours_go_from_the_low_to_the_high_end_and_gray_is_nothing) {
  ValueMap map = depths({0, 1, 2, 3});
  map.scale = {1, 3, 1};
  const Image image = colored(map);
  const auto color = [&](int x) {
    return glm::vec3(image.at(x, 0, 0), image.at(x, 0, 1), image.at(x, 0, 2));
  };
  EXPECT_EQ(color(0), heat_of_zero(0.5f));
  EXPECT_EQ(color(1), viridis(0));
  EXPECT_EQ(color(2), viridis(0.5f));
  EXPECT_EQ(color(3), viridis(1));
}

TEST(ValueFile, floats_keep_the_values) {
  TemporaryFolder folder;
  const ValueMap map = depths({0, 1.25f, 70000, 1e-3f});
  for (const char* name : {"a.npy", "a.pfm", "a.exr", "a.tif"}) {
    EXPECT_EQ(write_values(map, folder / name, {}, {}), "units");
    const Image read = read_image(folder / name);
    EXPECT_EQ(read.channels, 1) << name;
    EXPECT_EQ(read.values, map.values) << name;
  }
  // "chlist", four bytes for the size of the list, then the name of its first channel.
  const std::string exr = read_text_file(folder / "a.exr", 1 << 20);
  const std::size_t list = exr.find(std::string("chlist\0", 7));
  ASSERT_NE(list, std::string::npos);
  EXPECT_EQ(exr.substr(list + 11, 2), std::string("Z\0", 2));
}

TEST(ValueFile, png_holds_depth_in_round_steps_and_says_which) {
  TemporaryFolder folder;
  const ValueMap map = depths({0, 1.25f, 3.5f});
  EXPECT_EQ(write_values(map, folder / "a.png", {}, {}), "steps of 0.0001 units");
  EXPECT_EQ(write_values(map, folder / "b.png", 0.001, {}), "steps of 0.001 units");
  for (const auto& [name, step] : {std::pair{"a.png", 1e-4f}, {"b.png", 1e-3f}}) {
    const Image read = read_image(folder / name);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(std::lround(read.values[i] * 65535), std::lround(map.values[i] / step));
  }
  EXPECT_THAT(error_of([&] { write_values(map, folder / "c.png", 1e-5, {}); }),
              HasSubstr("steps of 0.0001 do"));
  EXPECT_FALSE(std::filesystem::exists(folder / "c.png"));
}

TEST(ValueFile, png_holds_alpha_in_steps_of_one_65535th) {
  TemporaryFolder folder;
  const ValueMap map{Quantity::alpha, 3, 1, {0, 0.5f, 1}, {}};
  EXPECT_EQ(write_values(map, folder / "a.png", {}, {}), "steps of 1/65535");
  EXPECT_THAT(read_image(folder / "a.png").values,
              ElementsAre(0, testing::FloatNear(0.5f, 1e-5f), 1));
}

TEST(ValueFile, the_step_is_the_least_round_one_that_holds_the_largest_depth) {
  EXPECT_DOUBLE_EQ(depth_step_for(65.5f), 0.001);
  EXPECT_DOUBLE_EQ(depth_step_for(65.6f), 0.002);
  EXPECT_DOUBLE_EQ(depth_step_for(200), 0.005);
  EXPECT_DOUBLE_EQ(depth_step_for(0), 0.001);
}

TEST(ValueFile, endings_of_8_bit_formats_are_refused) {
  for (const char* name : {"a.jpg", "a.ppm", "a.webp", "a"}) {
    EXPECT_THAT(error_of([&] { require_value_file("render", name, Quantity::depth); }),
                HasSubstr("use .npy, .exr, .pfm or .tif (floats), or .png (16 bits)"))
        << name;
  }
  EXPECT_NO_THROW(require_value_file("render", "A.PNG", Quantity::depth));
}

}  // namespace
}  // namespace qs
