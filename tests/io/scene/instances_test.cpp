// SPDX-License-Identifier: MIT
//
// Files of instances: transforms against straightforward formulas, and files that do not fit.
#include "io/scene/instances.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/cloud/cloud_memory.h"
#include "support/error_of.h"
#include "support/instances_text.h"
#include "support/oracle.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

class Instances : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& text, const std::string& name = "a.json") const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  TemporaryFolder folder_;
};

glm::dvec3 color_of(const GaussianCloud& cloud, std::size_t i, const glm::dvec3& direction) {
  return 0.5 + sh_sum(cloud, i, cloud.sh_degree, direction);
}

TEST_F(Instances, are_turned_scaled_moved_and_tinted) {
  const GaussianCloud one = random_cloud(40, 3, 6);
  write_scene(one, folder_ / "one.ply");
  const glm::dvec3 axis = glm::normalize(glm::dvec3(1, -2, 0.5));
  const std::vector<Instance> instances = {
      {},
      {{1, -2, 3}, glm::angleAxis(0.8, axis), 2.5, {0.5f, 1.25f, 0}},
      {{-30, 0, 8}, glm::angleAxis(-2.9, axis), 1e-3, {1, 1, 1}}};
  const Scene scene = read_scene(write(format_instances("one.ply", instances)));
  ASSERT_EQ(scene.cloud.size(), 120u);
  EXPECT_EQ(scene.format, "instances of ply, binary little endian");
  EXPECT_THAT(scene.warnings, IsEmpty());
  ASSERT_EQ(scene.parts.size(), 1u);
  EXPECT_EQ(scene.parts[0].name, "one.ply");
  EXPECT_EQ(scene.parts[0].content, "3 instances of 40 Gaussians");
  for (std::size_t k = 0; k < 120; ++k) {
    const std::size_t i = k % 40;
    const auto& [position, rotation, scale, tint] = instances[k / 40];
    const glm::dvec3 expected = position + scale * (rotation * glm::dvec3(one.positions[i]));
    EXPECT_LT(glm::distance(glm::dvec3(scene.cloud.positions[k]), expected),
              1e-6 * (1 + glm::length(expected)));
    const glm::dmat3 turn = glm::mat3_cast(rotation);
    const glm::dmat3 shape = scale * scale * turn * covariance(one, i) * glm::transpose(turn);
    const double largest = std::max({shape[0][0], shape[1][1], shape[2][2]});
    for (int c = 0; c < 3; ++c)
      EXPECT_LT(glm::distance(covariance(scene.cloud, k)[c], shape[c]), 1e-5 * largest);
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -0.7, 0.2 + 0.1 * double(i)));
    const glm::dvec3 color = glm::dvec3(tint) * color_of(one, i, direction);
    EXPECT_LT(glm::distance(color_of(scene.cloud, k, turn * direction), color), 2e-5) << k;
    EXPECT_EQ(scene.cloud.opacity_logits[k], one.opacity_logits[i]);
  }
}

TEST_F(Instances, the_first_instance_without_members_is_the_scene) {
  const GaussianCloud one = random_cloud(30, 1, 6);
  write_scene(one, folder_ / "one.ply");
  const Scene scene = read_scene(write(R"({"instances": [{}], "scene": "one.ply", "version": 1})"));
  EXPECT_EQ(scene.cloud.positions, one.positions);
  EXPECT_EQ(scene.cloud.sh, one.sh);
}

TEST_F(Instances, rotations_need_no_length_and_folders_below_are_found) {
  std::filesystem::create_directories(folder_ / "deep/er");
  write_scene(random_cloud(5, 0, 6), folder_ / "deep/er/one.ply");
  const Scene scene = read_scene(write(
      R"({"version": 1, "scene": "deep/er/one.ply", "instances": [{"rotation": [0, 0, 5, 0]}]})"));
  EXPECT_NEAR(glm::length(scene.cloud.rotations[0]), 1, 1e-6);
}

TEST_F(Instances, georeferenced_scenes_and_places_keep_their_digits) {
  GaussianCloud one = random_cloud(9, 0, 6);
  write_scene(one, folder_ / "near.ply");
  one.origin = {500000, 4650000, 200};
  write_scene(one, folder_ / "far.ply");
  const glm::dvec3 place = {500000.125, 4650000.25, 200};
  const auto expect_at = [&](const Scene& scene, const glm::dvec3& moved) {
    EXPECT_NE(scene.cloud.origin, glm::dvec3(0));
    for (std::size_t i = 0; i < 9; ++i)
      EXPECT_LT(glm::distance(scene.cloud.origin + glm::dvec3(scene.cloud.positions[i]),
                              moved + glm::dvec3(one.positions[i])),
                1e-4);
  };
  expect_at(read_scene(write(format_instances("near.ply", {{place}, {place}}))), place);
  expect_at(read_scene(write(format_instances("far.ply", {{{8, 0, 0}}}))),
            one.origin + glm::dvec3(8, 0, 0));
}

TEST_F(Instances, ignored_members_and_the_scene_s_warnings_are_told) {
  GaussianCloud one = random_cloud(9, 0, 6);
  one.positions[3].x = std::numeric_limits<float>::quiet_NaN();
  write_scene(one, folder_ / "one.ply");
  const Scene scene = read_scene(
      write(R"({"version": 1, "scene": "one.ply", "instances": [{"color": 1}, {"color": 2}]})"));
  EXPECT_EQ(scene.cloud.size(), 16u);
  EXPECT_THAT(scene.warnings,
              ElementsAre(HasSubstr("one.ply: 1 of 9 Gaussians were dropped"),
                          "The member 'color' of instances is not known and was ignored."));
}

TEST_F(Instances, more_than_the_memory_holds_has_a_sentence_with_the_count) {
  write_scene(random_cloud(20000, 3, 6), folder_ / "one.ply");
  std::string list = "{}";
  for (int i = 1; i < 300000; ++i) list += ",{}";
  const std::string error = error_of(
      [&] { read_scene(write(R"({"version":1,"scene":"one.ply","instances":[)" + list + "]}")); });
  EXPECT_THAT(error, HasSubstr("a.json: 300,000 instances of one.ply are 6,000,000,000 Gaussians"));
  // 12 + 12 + 16 + 4 + 16 * 12 bytes per Gaussian, twice.
  EXPECT_THAT(error, HasSubstr("which take 2.8 TB to draw; "));
  EXPECT_GT(available_memory(), 1u << 20);
}

TEST_F(Instances, every_claim_that_does_not_fit_has_a_sentence) {
  write_scene(random_cloud(3, 0, 6), folder_ / "one.ply");
  write(R"({"version": 1, "scene": "own.json", "instances": [{}]})", "own.json");
  const std::pair<const char*, const char*> cases[] = {
      {R"({"scene": "one.ply", "instances": [{}]})", "version is missing"},
      {R"({"version": 2, "scene": "one.ply", "instances": [{}]})", "version 2, only 1 exists"},
      {R"({"version": 1, "scene": 7, "instances": [{}]})", "scene is not a string"},
      {R"({"version": 1, "scene": "", "instances": [{}]})", "unsafe file name"},
      {R"({"version": 1, "scene": "../one.ply", "instances": [{}]})", "unsafe file name"},
      {R"({"version": 1, "scene": "/etc/passwd", "instances": [{}]})", "unsafe file name"},
      {R"({"version": 1, "scene": "http://a/one.ply", "instances": [{}]})", "unsafe file name"},
      {R"({"version": 1, "scene": "two.ply", "instances": [{}]})",
       "the scene two.ply that it names is missing"},
      {R"({"version": 1, "scene": "own.json", "instances": [{}]})",
       "its scene own.json consists of instances too"},
      {R"({"version": 1, "scene": "one.ply", "instances": []})",
       "instances is not a list of objects"},
      {R"({"version": 1, "scene": "one.ply", "instances": {}})",
       "instances is not a list of objects"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{}, 3]})",
       "instance 1: is not an object"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"position": [1, 2]}]})",
       "instance 0: position is not a list of 3 numbers"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"position": [1, 2, 1e999]}]})",
       "a number is out of range"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"rotation": [0, 0, 0, 0]}]})",
       "rotation has no direction"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"rotation": [1e200, 0, 0, 1e200]}]})",
       "rotation has no direction"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"scale": 0}]})", "scale is 0, but"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"scale": -1}]})", "scale is -1, but"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"scale": 1e10}]})", "scale is"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"tint": [1, -1, 1]}]})",
       "tint is -1, but"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"tint": 1}]})",
       "tint is not a list of 3 numbers"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{"position": [1e30, 0, 0]}]})",
       "a position that is NaN, infinite or beyond 1e19"},
      {R"({"version": 1, "scene": "one.ply", "instances": [{})", "not valid JSON"}};
  for (const auto& [text, sentence] : cases) {
    const std::filesystem::path path = write(text);
    const std::string error = error_of([&] { read_scene(path); });
    EXPECT_THAT(error, StartsWith(path.string())) << text;
    EXPECT_THAT(error, HasSubstr(sentence)) << text;
    EXPECT_THAT(error, Not(HasSubstr("\n"))) << text;
  }
}

TEST_F(Instances, a_file_that_names_itself_ends) {
  const auto path = write(R"({"version": 1, "scene": "a.json", "instances": [{}]})");
  EXPECT_THAT(error_of([&] { read_scene(path); }), HasSubstr("consists of instances too"));
}

}  // namespace
}  // namespace qs::test
