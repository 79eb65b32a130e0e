// SPDX-License-Identifier: MIT
// Frames against the reference, and who is to blame.
#include "app/inspect/oracle.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "raster/base/error.h"
#include "support/inspector.h"

namespace qs {
namespace {

using testing::HasSubstr;

class Oracle : public test::InspectorTest {};

TEST_F(Oracle, finds_nothing_in_a_lossless_frame) {
  const Verdict verdict =
      ask_oracle(*renderer_, camera_, settings_, render(kDefaultMode), std::nullopt, 2, {});
  EXPECT_FALSE(verdict.pixel.has_value()) << verdict_sentence(verdict, 2);
  EXPECT_GT(verdict.psnr, 70);
}

TEST_F(Oracle, names_pixel_tile_and_gaussian_of_a_planted_mistake) {
  Frame frame = render(kDefaultMode);
  const PixelReport pixel = inspect_pixel(frame, {101, 70}, settings_.background);
  ASSERT_FALSE(pixel.contributions.empty());
  const auto heavy = std::max_element(
      pixel.contributions.begin(), pixel.contributions.end(),
      [](const Contribution& a, const Contribution& b) { return a.weight < b.weight; });
  // The frame as a backend would leave it that forgot this Gaussian in this tile.
  auto& listed = frame.trace.listed;
  const auto begin = frame.trace.tile_begin[static_cast<std::size_t>(pixel.tile)];
  const auto end = frame.trace.tile_begin[static_cast<std::size_t>(pixel.tile) + 1];
  const auto at = std::find(listed.begin() + static_cast<std::ptrdiff_t>(begin),
                            listed.begin() + static_cast<std::ptrdiff_t>(end), heavy->gaussian);
  listed.erase(at);
  for (std::size_t t = static_cast<std::size_t>(pixel.tile) + 1; t < frame.trace.tile_begin.size();
       ++t)
    --frame.trace.tile_begin[t];
  const glm::vec3 wrong = inspect_pixel(frame, {101, 70}, settings_.background).color;
  for (int c = 0; c < 3; ++c) frame.color.at(101, 70, c) = wrong[c];

  const Verdict verdict =
      ask_oracle(*renderer_, camera_, settings_, frame, PixelBox{90, 60, 120, 90}, 2, {});
  ASSERT_TRUE(verdict.pixel.has_value());
  EXPECT_EQ(*verdict.pixel, glm::ivec2(101, 70));
  EXPECT_EQ(verdict.different_pixels, 1u);
  EXPECT_EQ(verdict.tile, pixel.tile);
  EXPECT_EQ(verdict.gaussian, heavy->gaussian);
  EXPECT_EQ(verdict.why, Disagreement::missing);
  EXPECT_THAT(verdict_sentence(verdict, 2), HasSubstr("101,70"));
}

TEST_F(Oracle, reports_its_progress_and_can_be_cancelled) {
  std::vector<float> reported;
  Progress progress{[&](float done) { reported.push_back(done); }, {}};
  ask_oracle(*renderer_, camera_, settings_, render(kDefaultMode), std::nullopt, 2, progress);
  EXPECT_GT(reported.size(), 4u);
  EXPECT_TRUE(std::is_sorted(reported.begin(), reported.end()));
  EXPECT_EQ(reported.back(), 1);
  std::stop_source stop;
  stop.request_stop();
  const Frame frame = render(kDefaultMode);
  EXPECT_THROW(
      ask_oracle(*renderer_, camera_, settings_, frame, std::nullopt, 2, {{}, stop.get_token()}),
      Cancelled);
}

}  // namespace
}  // namespace qs
