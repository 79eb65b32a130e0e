// SPDX-License-Identifier: MIT
// Selections and measures of the library; tests/python/select_test.py has more of both.
#include <numeric>

#include "library/opened_scene.h"
#include "support/scenes.h"

namespace qs {
namespace {

constexpr const char* kSteps = R"({"version": 1, "steps": [
  {"step": "select", "tool": "opacity", "low": 0.5}, {"step": "remove"},
  {"step": "select", "tool": "distance", "point": [0, 0, 0], "low": 5}]})";

class LibrarySelections : public testing::Test {
 protected:
  LibrarySelections() : scene_(context_.wrap(test::gaussians_of(cloud_))) {}

  const GaussianCloud cloud_ = test::random_cloud(500, 0, 6);
  quadsplat::Context context_ = test::cpu();
  quadsplat::Scene scene_;
};

TEST_F(LibrarySelections, have_a_value_for_each_gaussian) {
  std::vector<std::uint8_t> left;
  const std::vector<std::uint8_t> selected = scene_.select(kSteps, &left);
  ASSERT_EQ(selected.size(), 500u);
  for (std::size_t i = 0; i < selected.size(); ++i) {
    const glm::vec3 p = cloud_.positions[i];
    EXPECT_EQ(left[i], cloud_.opacity_logits[i] < 0);
    EXPECT_EQ(selected[i], left[i] == 1 && p.x * p.x + p.y * p.y + p.z * p.z >= 25) << i;
  }
  EXPECT_GT(std::accumulate(selected.begin(), selected.end(), 0), 20);
  EXPECT_EQ(scene_.select(kSteps), selected);
}

TEST_F(LibrarySelections, are_stored_with_strides_and_only_in_bytes) {
  std::vector<std::uint8_t> every_other(1000, 7);
  QsArray array = quadsplat::array_of(every_other.data(), {500});
  array.strides[0] = 2;
  quadsplat::check(qs_select, scene_.get(), kSteps, &array, nullptr);
  const std::vector<std::uint8_t> selected = scene_.select(kSteps);
  for (std::size_t i = 0; i < 500; ++i) {
    EXPECT_EQ(every_other[2 * i], selected[i]);
    EXPECT_EQ(every_other[2 * i + 1], 7);
  }
  std::vector<float> reals(500);
  const QsArray wrong = quadsplat::array_of(reals.data(), {500});
  EXPECT_NE(test::sentence_of(
                [&] { quadsplat::check(qs_select, scene_.get(), kSteps, &wrong, nullptr); }),
            "");
  const QsArray fewer = quadsplat::array_of(every_other.data(), {499});
  EXPECT_NE(test::sentence_of(
                [&] { quadsplat::check(qs_select, scene_.get(), kSteps, nullptr, &fewer); }),
            "");
  EXPECT_EQ(test::sentence_of([&] { scene_.select("{}"); }, QS_INPUT),
            "edits: is not a file of edits: it has no version or no steps");
}

TEST_F(LibrarySelections, and_pictures_stay_the_same) {
  const QsCamera camera = test::c_camera(test::front_camera(60, 40));
  const std::vector<float> before = test::colors(scene_, camera);
  scene_.select(R"({"version": 1, "steps": [{"step": "select", "tool": "all"}, {"step": "hide"},
    {"step": "show"}, {"step": "crop", "box": [[-1, -1, 0], [1, 1, 9]]},
    {"step": "select", "tool": "rectangle", "pixels": [[0, 0], [60, 40]],
     "camera": {"width": 60, "height": 40, "fx": 50, "fy": 50, "position": [0, 0, 0],
                "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}]})");
  EXPECT_EQ(test::colors(scene_, camera), before);
  const auto points = scene_.measure(camera, {30, 20, 59, 39});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(test::sentence_of([&] {
              scene_.measure(camera, {60, 0});
            }),
            "qs_measure: pixels[0]: 60,0 is outside of the picture of 60 x 40");
}

}  // namespace
}  // namespace qs
