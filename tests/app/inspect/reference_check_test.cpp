// SPDX-License-Identifier: MIT
// Comparisons of frames with the reference, which name the differences.
#include "app/inspect/reference_check.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "base/error.h"
#include "support/inspector.h"

namespace qs {
namespace {

using testing::HasSubstr;

class ReferenceCheckTest : public test::InspectorTest {
 protected:
  ReferenceCheck check(const Frame& frame, std::optional<PixelBox> region = {},
                       const Progress& progress = {}) {
    const CheckedView view{camera_, settings_, region};
    const Image reference = render_reference(*renderer_, view, progress);
    return check_against_reference(*renderer_, view, frame, reference, 2, progress);
  }
};

TEST_F(ReferenceCheckTest, finds_nothing_in_a_lossless_frame) {
  const ReferenceCheck result = check(render(default_mode()));
  EXPECT_FALSE(result.difference.first.has_value()) << check_sentence(result, 2);
  EXPECT_GT(result.difference.psnr, 70);
}

TEST_F(ReferenceCheckTest, names_pixel_tile_and_gaussian_of_a_planted_mistake) {
  const Frame complete = render(default_mode());
  const auto pixel_at = [](const Frame& frame, glm::ivec2 at) {
    return inspect_pixel(frame, at, glm::vec3(0));
  };
  glm::ivec2 stopping(0);  // the first pixel that stops before the end of its list
  while (!pixel_at(complete, stopping).stopped_by) {
    if (++stopping.x == camera_.width) stopping = {0, stopping.y + 1};
    ASSERT_LT(stopping.y, camera_.height);
  }
  for (const glm::ivec2 at : {glm::ivec2(101, 70), stopping}) {
    Frame frame = complete;
    const PixelReport pixel = pixel_at(frame, at);
    ASSERT_FALSE(pixel.contributions.empty());
    const auto heavy = std::max_element(
        pixel.contributions.begin(), pixel.contributions.end(),
        [](const Contribution& a, const Contribution& b) { return a.weight < b.weight; });
    // The frame of a backend that drops this Gaussian in this tile.
    auto& listed = frame.trace.listed;
    const auto tile = static_cast<std::size_t>(pixel.tile);
    const auto first = listed.begin() + static_cast<std::ptrdiff_t>(frame.trace.tile_begin[tile]);
    const auto last =
        listed.begin() + static_cast<std::ptrdiff_t>(frame.trace.tile_begin[tile + 1]);
    listed.erase(std::find(first, last, heavy->gaussian));
    for (std::size_t t = tile + 1; t < frame.trace.tile_begin.size(); ++t) {
      --frame.trace.tile_begin[t];
    }
    const glm::vec3 wrong = inspect_pixel(frame, at, settings_.background).color;
    for (int c = 0; c < 3; ++c) frame.color.at(at.x, at.y, c) = wrong[c];

    const PixelBox around{std::max(at.x - 11, 0), std::max(at.y - 10, 0),
                          std::min(at.x + 19, camera_.width), std::min(at.y + 20, camera_.height)};
    const ReferenceCheck result = check(frame, around);
    EXPECT_EQ(result.difference.first, at);
    EXPECT_EQ(result.difference.pixels, 1u);
    EXPECT_EQ(result.tile, pixel.tile);
    EXPECT_EQ(result.gaussian, heavy->gaussian);
    EXPECT_EQ(result.why, Disagreement::missing);
    EXPECT_THAT(check_sentence(result, 2),
                HasSubstr(std::to_string(at.x) + "," + std::to_string(at.y)));
  }
}

TEST_F(ReferenceCheckTest, reports_its_progress_and_can_be_cancelled) {
  std::vector<float> reported;
  Progress progress{[&](float done) { reported.push_back(done); }, {}};
  check(render(default_mode()), std::nullopt, progress);
  EXPECT_GT(reported.size(), 4u);
  EXPECT_TRUE(std::is_sorted(reported.begin(), reported.end()));
  EXPECT_EQ(reported.back(), 1);
  std::stop_source stop;
  stop.request_stop();
  const Frame frame = render(default_mode());
  EXPECT_THROW(check(frame, std::nullopt, {{}, stop.get_token()}), Cancelled);
}

}  // namespace
}  // namespace qs
