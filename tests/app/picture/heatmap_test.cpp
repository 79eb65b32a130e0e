// SPDX-License-Identifier: MIT
#include "app/picture/heatmap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/picture/canvas.h"
#include "app/picture/palette.h"
#include "base/text.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

using testing::HasSubstr;

TEST(Heatmap, total_of_pairs_is_the_frame_s_statistics_and_stands_in_the_legend) {
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::random_cloud(3000, 1, 1), {});
  const Camera camera = test::front_camera(133, 97);  // ends within a tile
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    RenderSettings settings;
    settings.mode = mode;
    const Frame& frame = renderer->render(camera, settings, outputs_for(HeatQuantity::pairs));
    const Heatmap map = make_heatmap(frame, HeatQuantity::pairs, camera.width, camera.height);
    EXPECT_EQ(map.total, frame.stats.tile_pairs);
    EXPECT_EQ(map.largest, frame.stats.max_pairs_in_a_tile);
    const Legend legend = make_legend(map, scale_for(map.values), "any");
    EXPECT_THAT(legend.facts, HasSubstr(grouped(frame.stats.tile_pairs) + " pairs in all"));
    EXPECT_THAT(legend.facts, HasSubstr("at most " + grouped(map.largest)));
  }
}

TEST(Legend, every_bar_has_the_colours_of_the_map_also_for_small_scales) {
  Heatmap map;
  map.values = {0, 1, 3};
  sum_up(map);
  const Legend legend = make_legend(map, {1, 4}, "any");
  const std::vector<glm::vec3> bar = bar_colors(legend, 800, 10);
  for (int x = 0; x < 100; ++x)  // below half a pair
    ASSERT_EQ(bar[static_cast<std::size_t>(x)], heat_of_zero(0.5f)) << x;
  EXPECT_EQ(bar[100], heat(100.5f / 800));
  const std::vector<glm::vec3> fine = bar_colors(make_legend(map, {500, 2000}, "any"), 800, 10);
  EXPECT_EQ(fine[4], heat_of_zero(0.5f)) << "half as wide as high";
  EXPECT_NE(fine[5], heat_of_zero(0.5f));
}

TEST(Legend, texts_of_ticks_never_touch_and_the_last_stays) {
  const std::vector<BarTick> ticks = {{0, "0"},
                                      {0.25f, "5,000"},
                                      {0.5f, "10,000"},
                                      {0.75f, "15,000"},
                                      {1, "20,000+ contributions"}};
  const auto text_width = [](const std::string& text) { return 8 * static_cast<int>(text.size()); };
  for (const int width : {200, 340, 1000}) {
    const std::vector<PlacedTick> placed = place_ticks(ticks, width, 8, text_width);
    int end = -8;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      if (!placed[i].has_text) continue;
      const int text = text_width(ticks[i].text);
      const int start = placed[i].text - static_cast<int>(placed[i].align) * text / 2;
      EXPECT_GE(start, end + 8) << width << ", tick " << i;
      end = start + text;
    }
    EXPECT_TRUE(placed.back().has_text);
    EXPECT_EQ(end, width);
  }
  EXPECT_TRUE(place_ticks(ticks, 1000, 8, text_width)[2].has_text);
}

TEST(Heatmap, evaluated_pairs_are_counted_per_pixel) {
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::random_cloud(3000, 0, 2), {});
  const Camera camera = test::front_camera(50, 40);
  const Frame& frame = renderer->render(camera, {}, outputs_for(HeatQuantity::evaluated));
  const Heatmap map = make_heatmap(frame, HeatQuantity::evaluated, camera.width, camera.height);
  EXPECT_EQ(map.values.size(), 50u * 40);
  EXPECT_EQ(map.columns, 50);
  EXPECT_GT(map.total, 0u);
  EXPECT_LE(map.total, frame.stats.tile_pairs * kTileSize * kTileSize);
}

Heatmap flat_map(int columns, int rows, std::uint32_t value) {
  Heatmap map;
  map.columns = columns;
  map.rows = rows;
  map.cell_px = kTileSize;
  map.values.assign(static_cast<std::size_t>(columns * rows), value);
  map.total = value * map.values.size();
  map.largest = value;
  return map;
}

TEST(Heatmap, a_tile_has_the_color_that_the_scale_prints_for_its_value) {
  Heatmap map = flat_map(4, 2, 100);
  map.values[5] = 300;  // second row, second column
  const Image color(64, 32, 3);
  const Image picture = draw_heatmap(color, map, round_scale(400), "exact");
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(picture.at(20, 20, c), heat(0.75f)[c]);
    EXPECT_FLOAT_EQ(picture.at(60, 4, c), heat(0.25f)[c]);
  }
}

TEST(Heatmap, the_mean_color_of_a_tile_is_its_value_s_at_every_tile_size) {
  constexpr int kWidth = 72, kHeight = 40;  // neither is a multiple of all sizes
  Image color(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c)
        color.at(x, y, c) = static_cast<float>((7 * x + 13 * y) % 72) / 72;
    }
  }
  for (const int side : kTileSizes) {
    Heatmap map = flat_map((kWidth + side - 1) / side, (kHeight + side - 1) / side, 0);
    map.cell_px = side;
    for (std::size_t i = 0; i < map.values.size(); ++i)
      map.values[i] = static_cast<std::uint32_t>(1 + 37 * i % 100);
    const Image picture = draw_heatmap(color, map, round_scale(100), "exact");
    for (std::size_t tile = 0; tile < map.values.size(); ++tile) {
      const int left = static_cast<int>(tile) % map.columns * side,
                top = static_cast<int>(tile) / map.columns * side;
      const int right = std::min(left + side, kWidth), bottom = std::min(top + side, kHeight);
      glm::vec3 mean(0);
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x)
          mean += glm::vec3(picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2));
      }
      mean /= static_cast<float>((right - left) * (bottom - top));
      const glm::vec3 expected = heat(static_cast<float>(map.values[tile]) / 100);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], expected[c], 1e-4f) << side << " " << tile;
    }
  }
}

TEST(Heatmap, zero_is_neutral_and_darker_than_every_count_whatever_the_picture_shows) {
  const auto lightness = [](glm::vec3 c) { return 0.299f * c.r + 0.587f * c.g + 0.114f * c.b; };
  const auto at = [](const Image& image, int x, int y) {
    return glm::vec3(image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2));
  };
  // Two tiles, left without pairs. Stripes of black and white are the strongest detail.
  Heatmap map = flat_map(2, 1, 0);
  Image color(32, 16, 3);
  for (int x = 0; x < color.width; x += 2) {
    for (int y = 0; y < color.height; ++y)
      for (int c = 0; c < 3; ++c) color.at(x, y, c) = 1;
  }
  for (const std::uint32_t value : {1u, 10u, 1000u, 5000u}) {
    map.values[1] = value;
    const Image picture = draw_heatmap(color, map, round_scale(1000), "exact");
    float darkest = 1, lightest_zero = 0;
    for (int x = 0; x < 16; ++x) {
      const glm::vec3 zero = at(picture, x, 5);
      EXPECT_EQ(zero.r, zero.g);
      EXPECT_EQ(zero.g, zero.b);
      lightest_zero = std::max(lightest_zero, lightness(zero));
      darkest = std::min(darkest, lightness(at(picture, x + 16, 5)));
    }
    EXPECT_LT(lightest_zero, darkest) << value;
    EXPECT_NE(at(picture, 0, 5), at(picture, 1, 5)) << "the picture stays visible";
    EXPECT_GT(darkest, 0.5f * lightness(heat(0))) << "no black edges in tiles with few pairs";
  }
}

TEST(Heatmap, detail_dims_every_colour_by_the_same_factor) {
  for (const float t : {0.0f, 0.3f, 1.0f}) {
    for (const float detail : {-0.5f, 0.0f, 0.25f}) {
      const glm::vec3 color = heat(t), shown = with_detail(color, detail);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], (1 + detail / 2) * color[c], 1e-6f);
    }
  }
}

TEST(Heatmap, the_legend_is_below_the_frame_and_has_ink_at_any_size) {
  for (const auto& [width, height] :
       {std::pair{1600, 1200}, {640, 480}, {200, 100}, {16, 16}, {1, 1}}) {
    const int columns = (width + 15) / 16, rows = (height + 15) / 16;
    const Image picture = draw_heatmap(Image(width, height, 3), flat_map(columns, rows, 7),
                                       round_scale(7), "quadbox");
    EXPECT_EQ(picture.width, width);
    EXPECT_GT(picture.height, height + 40);
    float brightest = 0;
    for (int y = height; y < picture.height; ++y) {
      for (int x = 0; x < width; ++x) brightest = std::max(brightest, picture.at(x, y, 2));
    }
    EXPECT_TRUE(width < 200 || brightest > 0.8f);
  }
}

TEST(PairDifference, has_signs_and_a_total) {
  const std::vector<std::uint32_t> a = {5, 0, 7}, b = {2, 4, 7};
  const PairDifference difference = pair_difference({3, 1, 16}, a, b);
  EXPECT_THAT(difference.values, testing::ElementsAre(3, -4, 0));
  EXPECT_EQ(difference.total, -1);
}

TEST(Scale, has_round_steps_and_reaches_the_maximum) {
  for (const std::uint32_t maximum :
       {0u, 1u, 3u, 7u, 9u, 42u, 99u, 1001u, 3711u, 999999u, 4294967295u}) {
    const Scale scale = round_scale(maximum);
    EXPECT_GE(scale.maximum, std::min(maximum, 4'000'000'000u));
    EXPECT_EQ(scale.maximum % scale.step, 0u);
    EXPECT_LE(scale.ticks().size(), 9u);
    EXPECT_EQ(scale.ticks().front(), 0u);
    EXPECT_EQ(scale.ticks().back(), scale.maximum);
  }
  EXPECT_EQ(round_scale(3711).step, 500u);
}

TEST(Scale, a_few_extreme_values_do_not_darken_the_others) {
  std::vector<std::uint32_t> values(1000, 90);
  values[3] = 1000000;
  EXPECT_EQ(scale_for(values).maximum, 100u);
  Heatmap map;
  map.values = values;
  map.largest = 1000000;
  EXPECT_EQ(make_legend(map, scale_for(values), "any").ticks.back().text, "100+");
}

TEST(Legend, every_tick_of_a_map_of_missed_contributions_has_its_number) {
  Heatmap map;
  map.quantity = HeatQuantity::missed;
  map.largest = 40;
  const Legend legend = make_legend(map, {2, 16}, "dualbox");
  const auto text_width = [](const std::string& text) { return 9 * static_cast<int>(text.size()); };
  for (const PlacedTick& tick : place_ticks(legend.ticks, 400, 7, text_width))
    EXPECT_TRUE(tick.has_text) << tick.line;
  EXPECT_EQ(legend.ticks.back().text, "16+");
}

TEST(Font, measures_what_it_draws_and_knows_latin_1) {
  const Font font(24);
  EXPECT_GT(font.width("16 \u00d7 16"), font.width("16  16"));
  EXPECT_EQ(font.width("000"), font.width("123")) << "digits have one width, so that numbers align";
  Image image(200, 40, 3);
  const int width = draw_text(image, font, {5, 5}, "Tile pairs", glm::vec3(1));
  int rightmost = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image.at(x, y, 0) > 0) rightmost = std::max(rightmost, x);
    }
  }
  EXPECT_NEAR(rightmost, 5 + width, 3);
  draw_text(image, font, {190, 35}, "clipped at the border \xf0\x9f\x98\x80 \xff", glm::vec3(1));
}

TEST(Colormap, viridis_rises_steadily_in_lightness) {
  float last = -1;
  for (int i = 0; i <= 100; ++i) {
    const glm::vec3 color = viridis(static_cast<float>(i) / 100);
    const float lightness = 0.2126f * color.r + 0.7152f * color.g + 0.0722f * color.b;
    EXPECT_GT(lightness, last);
    last = lightness;
  }
}

TEST(Colormap, of_counts_is_viridis_from_a_fifth_on) {
  for (int i = 0; i <= 10; ++i) {
    const float t = static_cast<float>(i) / 10;
    for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(heat(t)[c], viridis(0.2f + 0.8f * t)[c]);
  }
  EXPECT_EQ(heat(-1), heat(0));
  EXPECT_EQ(heat(2), heat(1));
}

TEST(Colormap, of_signed_values_is_lightest_at_zero_and_darkens_alike_on_both_sides) {
  const auto lightness = [](glm::vec3 c) { return 0.299f * c.r + 0.587f * c.g + 0.114f * c.b; };
  for (float t = 0.05f; t <= 1; t += 0.05f) {
    EXPECT_LT(lightness(diverging(t)), lightness(diverging(t - 0.05f)));
    EXPECT_LT(lightness(diverging(-t)), lightness(diverging(0.05f - t)));
    EXPECT_NEAR(lightness(diverging(t)), lightness(diverging(-t)), 0.1f);
    EXPECT_GT(diverging(t).r, diverging(t).b);
    EXPECT_LT(diverging(-t).r, diverging(-t).b);
  }
}

TEST(Scale, of_signed_values_reaches_as_far_on_both_sides) {
  const std::vector<std::int32_t> values = {-70, 3, 12};
  EXPECT_EQ(scale_for_signed(values).maximum,
            scale_for(std::vector<std::uint32_t>{70, 3, 12}).maximum);
}

}  // namespace
}  // namespace qs
