// SPDX-License-Identifier: MIT
//
// The scenes of scripts/make_huge.
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/session/placed_cameras.h"
#include "app/support/run_program.h"
#include "huge/city.h"
#include "huge/copies.h"
#include "io/camera/cameras.h"
#include "raster/api/renderer.h"
#include "support/paths.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::HasSubstr;

void expect_equal(const GaussianCloud& a, const GaussianCloud& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.log_scales, b.log_scales);
  EXPECT_EQ(a.rotations, b.rotations);
  EXPECT_EQ(a.opacity_logits, b.opacity_logits);
  EXPECT_EQ(a.sh, b.sh);
}

double sigma(const GaussianCloud& cloud, std::size_t i, int axis) {
  return std::exp(static_cast<double>(cloud.log_scales[i][axis]));
}

// ---- the city -----------------------------------------------------------------------------------

TEST(City, parts_are_equal_in_any_order_and_with_any_threads) {
  const City city(450'000, 1, 7);
  ThreadPool one(1), four(4);
  const GaussianCloud all = city.part(0, 450'000, four);
  for (const auto& [begin, end] : std::vector<std::pair<std::size_t, std::size_t>>{
           {449'999, 450'000}, {0, 1}, {112'400, 112'600}, {220'000, 240'001}}) {
    const GaussianCloud part = city.part(begin, end, one);
    ASSERT_EQ(part.size(), end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      ASSERT_EQ(part.positions[i - begin], all.positions[i]) << i;
      ASSERT_EQ(part.rotations[i - begin], all.rotations[i]);
      ASSERT_EQ(part.sh[4 * (i - begin) + 3], all.sh[4 * i + 3]);
    }
  }
  EXPECT_NE(City(450'000, 1, 8).part(0, 100, one).positions, city.part(0, 100, one).positions);
}

TEST(City, every_number_of_gaussians_is_a_sound_scene) {
  for (const std::size_t count : {1u, 2u, 49u, 51u, 1000u, 299'999u, 450'001u}) {
    const City city(count, count % 4, 3);
    const GaussianCloud cloud = city.part(0, count, pool());
    ASSERT_EQ(cloud.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_TRUE(is_finite(cloud.positions[i])) << count << " " << i;
      ASSERT_TRUE(is_finite(cloud.log_scales[i])) << count << " " << i;
      ASSERT_NEAR(glm::length(cloud.rotations[i]), 1, 1e-5) << count << " " << i;
      ASSERT_TRUE(std::isfinite(cloud.opacity_logits[i]));
    }
    for (const glm::vec3& value : cloud.sh) ASSERT_TRUE(is_finite(value));
  }
}

TEST(City, has_all_kinds_at_their_places) {
  const std::size_t count = 900'000;  // 2 x 2 blocks of 80
  const City city(count, 0, 1);
  const GaussianCloud cloud = city.part(0, count, pool());
  std::map<CityKind, std::size_t> counts;
  for (std::size_t i = 0; i < count; ++i) {
    const CityKind kind = city.kind(i);
    ++counts[kind];
    const glm::vec3 p = cloud.positions[i];
    const bool inside = std::abs(p.x) <= 80.01f && std::abs(p.z) <= 80.01f;
    switch (kind) {
      case CityKind::sky:
        EXPECT_NEAR(glm::length(p), 2 * 80 + 300, 0.01);
        break;
      case CityKind::ground:
        EXPECT_TRUE(inside);
        EXPECT_EQ(p.y, 0);
        break;
      case CityKind::wire:
        EXPECT_TRUE(inside);
        EXPECT_NEAR(2 * sigma(cloud, i, 1), 0.02, 1e-6);
        EXPECT_NEAR(2 * sigma(cloud, i, 2), 0.02, 1e-6);
        EXPECT_LE(p.y, -6);
        EXPECT_GE(p.y, -8);
        break;
      case CityKind::leaf:
        EXPECT_TRUE(inside);
        EXPECT_LE(p.y, -2.4f);
        EXPECT_GE(p.y, -7.6f);
        break;
      case CityKind::facade:
        EXPECT_TRUE(inside);
        EXPECT_LE(p.y, 0);
        EXPECT_GE(p.y, -45);
        EXPECT_LT(sigma(cloud, i, 2), 0.011);
        break;
    }
  }
  EXPECT_EQ(counts[CityKind::sky], count / 50);
  EXPECT_EQ(counts[CityKind::ground], 4 * count / 50);
  EXPECT_EQ(counts[CityKind::wire], 2 * count / 50);
  EXPECT_EQ(counts[CityKind::leaf], 13 * count / 50);
  EXPECT_EQ(counts[CityKind::facade], 30 * count / 50);
}

// The wires of a street lie end to end: along z at each edge of a block.
TEST(City, wires_are_closed_lines) {
  const City city(200'000, 0, 1);
  const GaussianCloud cloud = city.part(0, city.size(), pool());
  std::vector<double> places;  // of one wire
  double longest = 0;
  for (std::size_t i = 0; i < city.size(); ++i) {
    if (city.kind(i) != CityKind::wire) continue;
    const glm::vec3 p = cloud.positions[i];
    const double along = (static_cast<double>(p.x) + 40) / 80, sag = 4 * along * (1 - along);
    if (std::abs(static_cast<double>(p.z) + 33) > 1e-3 ||
        std::abs(-static_cast<double>(p.y) - (7 - 0.8 * sag)) > 1e-3)
      continue;
    places.push_back(static_cast<double>(p.x));
    longest = std::max(longest, sigma(cloud, i, 0));
  }
  ASSERT_GT(places.size(), 1000u);
  std::ranges::sort(places);
  for (std::size_t k = 1; k < places.size(); ++k) EXPECT_LT(places[k] - places[k - 1], 2 * longest);
  EXPECT_LT(places.front(), -39.9);
  EXPECT_GT(places.back(), 39.9);
}

TEST(City, its_cameras_see_no_holes) {
  const City city(400'000, 0, 1);
  const auto renderer = make_renderer(Backend::cpu, pool());
  renderer->upload(city.part(0, city.size(), pool()), {});
  Outputs outputs;
  outputs.depth = true;
  for (const Camera& camera : city.cameras()) {
    const Frame& frame = renderer->render(camera.resized(200, 150), {}, outputs);
    int holes = 0;
    for (const float alpha : frame.depth.alpha) holes += alpha < 0.5f ? 1 : 0;
    EXPECT_LT(holes, 200 * 150 / 100) << camera.name;
  }
}

// ---- copies -------------------------------------------------------------------------------------

TEST(Copies, differ_and_do_not_meet) {
  const GaussianCloud scene = random_cloud(500, 0, 3);
  const Copies copies = scatter_copies(scene, 50, 1);
  ASSERT_EQ(copies.instances.size(), 50u);
  std::set<double> scales;
  for (const Instance& copy : copies.instances) {
    scales.insert(copy.scale);
    EXPECT_GE(copy.scale, 0.7);
    EXPECT_LE(copy.scale, 1.3);
    EXPECT_NEAR(glm::length(copy.rotation), 1, 1e-12);
    EXPECT_GE(copy.tint.g, 0.7f);
    EXPECT_LE(copy.tint.g, 1.2f);
    // The vertical axis tilts by at most 10 degrees.
    EXPECT_GE((copy.rotation * glm::dvec3(0, 1, 0)).y, std::cos(10.001 * 3.14159265 / 180));
  }
  EXPECT_EQ(scales.size(), 50u);
  EXPECT_EQ(scatter_copies(scene, 50, 1).instances[49].position, copies.instances[49].position);
  EXPECT_NE(scatter_copies(scene, 50, 2).instances[49].scale, copies.instances[49].scale);
}

// ---- the program --------------------------------------------------------------------------------

class MakeHuge : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  static ProgramRun make(const std::vector<std::string>& words) {
    const std::filesystem::path quadsplat = quadsplat_program();
    return run_program((quadsplat.parent_path() / "make_huge").string(), words);
  }

  TemporaryFolder folder_;
};

TEST_F(MakeHuge, a_city_is_written_in_parts) {
  const ProgramRun run =
      make({"city", path("city.ply"), "--count", "300001", "--sh-degree", "1", "--seed", "5"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("city.ply (300,001 Gaussians, 31.2 MB) and "));
  const Scene scene = read_scene(path("city.ply"));
  EXPECT_TRUE(scene.warnings.empty());
  expect_equal(scene.cloud, City(300'001, 1, 5).part(0, 300'001, pool()));
  EXPECT_EQ(read_cameras(path("city_cameras.json")).size(), 4u);
}

TEST_F(MakeHuge, baked_copies_are_the_instances) {
  const GaussianCloud one = random_cloud(300, 2, 4);
  write_scene(one, path("one.ply"));
  for (const char* out : {"baked.ply", "small.instances.json"}) {
    const ProgramRun run = make({"copies", path("one.ply"), path(out), "--copies", "7"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("(2,100 Gaussians, "));
  }
  const GaussianCloud baked = read_scene(path("baked.ply")).cloud;
  expect_equal(baked, read_scene(path("small.instances.json")).cloud);
  EXPECT_TRUE(sees_scene(read_cameras(path("baked_cameras.json")), baked));
  EXPECT_LT(std::filesystem::file_size(path("small.instances.json")), 4000u);
  ASSERT_EQ(
      make({"copies", path("one.ply"), path("flat.instances.json"), "--sh-degree", "0"}).exit_code,
      0);
  EXPECT_EQ(read_scene(path("flat.instances.json")).cloud.sh_degree, 0);
}

TEST_F(MakeHuge, wrong_words_have_a_sentence) {
  write_scene(random_cloud(3, 0, 4), path("one.ply"));
  const auto expect = [&](const std::vector<std::string>& words, const std::string& sentence) {
    const ProgramRun run = make(words);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, HasSubstr(sentence));
  };
  expect({}, "make_huge: give city or copies");
  expect({"town", path("a.ply")}, "make_huge: give city or copies");
  expect({"city", path("a.spz")}, "the name must end in .ply");
  expect({"city", path("a.instances.json")}, "the name must end in .ply");
  expect({"copies", path("one.ply"), path("a.json")}, "must end in .ply or .instances.json");
  expect({"copies", path("two.ply"), path("a.ply")}, "two.ply: does not exist");
  expect({"copies", path("one.ply"), path("one.ply")}, "is an input of this command");
  expect({"city", path("a.ply"), "--count", "0"}, "--count");
  expect({"city", path("no/a.ply")}, "no");
  ASSERT_EQ(make({"city", path("a.ply"), "--count", "100"}).exit_code, 0);
  expect({"city", path("a.ply"), "--count", "100"}, "exists already");
  EXPECT_EQ(make({"city", path("a.ply"), "--count", "100", "--overwrite"}).exit_code, 0);
}

}  // namespace
}  // namespace qs::test
