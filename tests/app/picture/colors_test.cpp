// SPDX-License-Identifier: MIT
//
// Colours compared with the published tables from which they come, and scales compared with a
// search over all round steps.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/picture/figure.h"
#include "app/picture/legend.h"
#include "app/picture/palette.h"

namespace qs {
namespace {

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

TEST(Colors, viridis_has_the_published_colours_at_every_eighth_and_is_linear_between_them) {
  const std::vector<std::string> published = words_of(
      "#440154 #470D60 #48186A #482374 #472D7B #453781 #424086 #3E4989 #3B528B #375B8D #33638D "
      "#2F6B8E #2C728E #297A8E #26828E #23898E #21918C #1F978B #1F9F88 #21A685 #27AD81 #31B57B "
      "#3DBC74 #4CC26C #5CC863 #6ECE58 #81D34D #95D840 #AADC32 #C0DF25 #D5E21A #EAE51A #FDE725");
  for (std::size_t i = 0; i < published.size(); ++i) {
    const float t = static_cast<float>(i) / 32;
    EXPECT_EQ(hex_text(viridis(t)), published[i]) << i;
    if (i == 32) continue;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(viridis(t + 0.25f / 32)[c],
                  0.75f * viridis(t)[c] + 0.25f * viridis(t + 1.0f / 32)[c], 1e-5f);
  }
  EXPECT_EQ(viridis(-3), viridis(0));
  EXPECT_EQ(viridis(7), viridis(1));
}

// (L + 0.05) / (l + 0.05), by WCAG 2.
double contrast_on_white(glm::vec3 color) {
  constexpr double kShares[] = {0.2126, 0.7152, 0.0722};
  double luminance = 0;
  for (int c = 0; c < 3; ++c) {
    const auto v = static_cast<double>(color[c]);
    luminance += kShares[c] * (v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
  }
  return 1.05 / (luminance + 0.05);
}

TEST(Colors, names_of_modes_are_readable_on_white_and_keep_colours_that_are) {
  for (CullMode mode = -1; mode <= mode_count(); ++mode) {
    const glm::vec3 color = on_white::mode_color(mode), light = mode_color(mode);
    EXPECT_GE(contrast_on_white(color), 4.5) << mode;
    EXPECT_EQ(color == light, contrast_on_white(light) >= 4.6) << mode;
    EXPECT_LT(contrast_on_white(color), std::max(5.2, contrast_on_white(light) + 0.01)) << mode;
  }
}

TEST(Figure, lines_are_drawn_and_stay_lines_in_the_svg) {
  Figure figure;
  figure.size = {60, 40};
  figure.lines = {{{{10, 10}, {50, 10}}, {kBlue, 4}},
                  {{{30, 30}, {30, 30}}, {kRed, 10}},
                  {{{5, 20}, {15, 20}, {10, 35}}, {kGreen, 2, 0.5f}, true}};
  const Image page = draw_figure(figure);
  const auto pixel = [&](int x, int y) {
    return hex_text({page.at(x, y, 0), page.at(x, y, 1), page.at(x, y, 2)});
  };
  EXPECT_EQ(pixel(30, 10), hex_text(kBlue));
  EXPECT_EQ(pixel(30, 29), hex_text(kRed)) << "a dot";
  EXPECT_EQ(pixel(55, 35), "#FFFFFF");
  const std::string svg = figure_svg(figure, "lines");
  EXPECT_THAT(svg, testing::HasSubstr("<polyline points=\"10.0,10.0 50.0,10.0 \" fill=\"none\" "
                                      "stroke=\"#0072B2\" stroke-width=\"4\""));
  EXPECT_THAT(svg, testing::HasSubstr("<polyline points=\"30.0,30.0 30.0,30.0 \""));
  EXPECT_THAT(svg, testing::HasSubstr("<polygon points=\"5.0,20.0 15.0,20.0 10.0,35.0 \""));
}

TEST(Colors, of_signed_values_pass_through_seven_colours) {
  const std::vector<std::string> colours =
      words_of("#0B3C6E #3A7FB8 #9CC7E4 #F2F2F0 #F4B677 #CC6F1D #6E3507");
  for (int i = -3; i <= 3; ++i)
    EXPECT_EQ(hex_text(diverging(static_cast<float>(i) / 3)),
              colours[static_cast<std::size_t>(i + 3)]);
  EXPECT_EQ(diverging(-2), diverging(-1));
  EXPECT_EQ(diverging(2), diverging(1));
}

TEST(Colors, accents_are_okabe_and_ito_s) {
  EXPECT_EQ(rgb(0x3366FF), glm::vec3(0.2f, 0.4f, 1));
  EXPECT_EQ(hex_text({0.2f, 0.4f, 1}), "#3366FF");
  EXPECT_EQ(hex_text({2, -1, 0.5f}), "#FF0080") << "clamped";
  std::string text;
  for (const glm::vec3 color : {kOrange, kSkyBlue, kGreen, kBlue, kVermillion, kPurple})
    text += hex_text(color) + " ";
  EXPECT_EQ(text, "#E69F00 #56B4E9 #009E73 #0072B2 #D55E00 #CC79A7 ");
}

TEST(Colors, of_paper_and_dark_panels_are_gray_and_in_the_order_of_their_brightness) {
  using on_white::kFaint, on_white::kInk, on_white::kLine, on_white::kPanel, on_white::kWhite;
  std::string text;
  for (const glm::vec3 color : {kInk, kFaint, kLine, kPanel, kWhite, on_dark::kPanel,
                                on_dark::kFaint, on_dark::kText, kRed, kGray, kLightGray})
    text += hex_text(color) + " ";
  EXPECT_EQ(text,
            "#1A1C21 #6B707A #D5D7DB #F6F7F8 #FFFFFF #16171B #999EA6 #E6E8EB #D92626 #808080 "
            "#BBBBBB ");
}

TEST(Colors, of_modes_differ_and_black_and_blue_are_lighter_on_dark) {
  struct ModeColor {
    const char* mode;
    std::string light, dark;
  };
  const ModeColor published[] = {
      {"no mode", "#808080", "#808080"},  {"reference", "#009E73", "#009E73"},
      {"3dgs", "#000000", "#BBBBBB"},     {"adr", "#E69F00", "#E69F00"},
      {"dualbox", "#56B4E9", "#56B4E9"},  {"quadbox-naive", "#CC79A7", "#CC79A7"},
      {"quadbox", "#0072B2", "#268CD9"},  {"exact", "#D55E00", "#D55E00"},
      {"snugbox", "#8FC9A0", "#8FC9A0"},  {"accutile", "#8C6D31", "#8C6D31"},
      {"flashgs", "#A39BD0", "#A39BD0"},  {"stopthepop", "#C9B458", "#C9B458"},
      {"faster-gs", "#B5838D", "#B5838D"}};
  for (const ModeColor& color : published) {
    EXPECT_EQ(hex_text(mode_color(find_culler(color.mode))), color.light) << color.mode;
    EXPECT_EQ(hex_text(on_dark::mode_color(find_culler(color.mode))), color.dark) << color.mode;
  }
  std::set<std::string> light, dark;
  for (CullMode mode = -1; mode <= mode_count(); ++mode) {
    light.insert(hex_text(mode_color(mode)));
    dark.insert(hex_text(on_dark::mode_color(mode)));
  }
  EXPECT_EQ(light.size(), static_cast<std::size_t>(mode_count() + 2));
  EXPECT_EQ(dark.size(), static_cast<std::size_t>(mode_count() + 2));
}

TEST(RoundScale, takes_the_smallest_round_step_of_which_at_most_eight_reach_the_maximum) {
  std::vector<std::uint64_t> steps;
  for (std::uint64_t power = 1; power <= 1'000'000'000; power *= 10)
    steps.insert(steps.end(), {power, 2 * power, 5 * power});
  for (std::uint64_t maximum = 1; maximum < 4'000'000'000; maximum += maximum / 19 + 1) {
    const auto step = *std::find_if(steps.begin(), steps.end(),
                                    [&](std::uint64_t s) { return 8 * s >= maximum; });
    const Scale scale = round_scale(static_cast<std::uint32_t>(maximum));
    EXPECT_EQ(scale.step, step) << maximum;
    EXPECT_EQ(scale.maximum, (maximum + step - 1) / step * step) << maximum;
    EXPECT_EQ(scale.ticks().size(), scale.maximum / step + 1);
    EXPECT_EQ(scale.ticks().at(1), step);
  }
  EXPECT_EQ(round_scale(0).maximum, 1u);
  EXPECT_EQ(round_scale(4294967295u).maximum, 4'000'000'000u);
  EXPECT_EQ(round_scale(4'000'000'000u).step, 500'000'000u);
}

TEST(RoundScale, ignores_the_largest_half_per_cent_of_the_values) {
  const auto reach = [](std::size_t large) {  // of 1001 values
    std::vector<std::uint32_t> values(1001, 7);
    for (std::size_t i = 0; i < large; ++i) values[i * 31 % 1001] = 4000;
    return scale_for(values).maximum;
  };
  EXPECT_EQ(reach(0), 7u);
  EXPECT_EQ(reach(5), 7u);
  EXPECT_EQ(reach(6), 4000u);
  EXPECT_EQ(scale_for({}).maximum, 1u);
  EXPECT_EQ(scale_for({}).step, 1u);
  const std::vector<std::int32_t> extremes = {INT32_MIN, -1, 2};
  EXPECT_EQ(scale_for_signed(std::span(extremes).subspan(1)).maximum, 1u)
      << "the middle of 1 and 2";
  EXPECT_EQ(scale_for_signed(std::span(extremes).first(1)).maximum,
            round_scale(2147483648u).maximum);
}

}  // namespace
}  // namespace qs
