// SPDX-License-Identifier: MIT
//
// Georeferenced data: the origin that is chosen, and files and cameras that keep their places.
#include "raster/scene/place.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "support/scene_files.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::HasSubstr;

// Positions in a box of that size around a middle.
glm::dvec3 position_of(std::size_t i, const glm::dvec3& middle, double size) {
  const auto share = [](std::size_t n) { return static_cast<double>(n % 101) / 100 - 0.5; };
  return middle + size * glm::dvec3(share(i * 7), share(i * 13), share(i * 29));
}

TEST(Place, the_origin_is_a_round_number_near_data_that_is_far_away) {
  struct Row {
    glm::dvec3 middle;
    double size;
    glm::dvec3 origin;
  };
  for (const Row& row :
       std::initializer_list<Row>{{{500123.4, 4650012.7, 230}, 2, {500120, 4650010, 230}},
                                  {{500123.4, 4650012.7, 230}, 50, {500100, 4650000, 200}},
                                  {{500123.4, 4650012.7, 230}, 900, {500000, 4650000, 0}},
                                  {{-4200123, 172345, 4780012}, 30, {-4200100, 172300, 4780000}},
                                  {{32000, -42000, 3}, 2, {32000, -42000, 0}},
                                  {{0, 0, 0}, 2, {0, 0, 0}},
                                  {{900, 0, 0}, 2, {0, 0, 0}},      // near 0
                                  {{5000, 0, 0}, 1000, {0, 0, 0}},  // as large as far away
                                  {{1e12, 0, 0}, 1, {0, 0, 0}}}) {  // no place
    SCOPED_TRACE(testing::Message() << row.middle.x << " " << row.size);
    EXPECT_EQ(origin_of(5000, [&](std::size_t i) { return position_of(i, row.middle, row.size); }),
              row.origin);
  }
  EXPECT_EQ(origin_of(0, [](std::size_t) { return glm::dvec3(1e6); }), glm::dvec3(0));
  // Strays do not move it.
  EXPECT_EQ(
      origin_of(
          1000,
          [](std::size_t i) {
            return i % 50 == 3 ? glm::dvec3(-1e8) : position_of(i, {500123, 4650012, 230}, 50);
          }),
      glm::dvec3(500100, 4650000, 200));
}

TEST(Place, text_of_an_origin_is_read_back) {
  for (const glm::dvec3 origin : {glm::dvec3(0), {500000, 4650000, 200}, {-1.5, 2e-3, 1e8}})
    EXPECT_EQ(parse_origin(format_origin(origin)), origin);
  for (const char* text : {"", "1 2", "1 2 x", "1 2 3 4", "nan 0 0", "1e12 0 0"})
    EXPECT_EQ(parse_origin(text), std::nullopt) << text;
}

// A .ply of 60 Gaussians whose positions have that type.
std::filesystem::path write_ply_of(const std::filesystem::path& path, const char* type,
                                   const glm::dvec3& middle, const std::string& comment = "") {
  std::ofstream file(path);
  file << "ply\nformat ascii 1.0\n" << comment << "element vertex 60\n";
  for (const char* name : {"x", "y", "z"}) file << "property " << type << " " << name << "\n";
  for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                           "rot_0", "rot_1", "rot_2", "rot_3"})
    file << "property float " << name << "\n";
  file << "end_header\n";
  for (std::size_t i = 0; i < 60; ++i) {
    const glm::dvec3 at = position_of(i, middle, 2);
    file << fmt::format("{} {} {} 0 0 0 1 -3 -3 -3 1 0 0 0\n", at.x, at.y, at.z);
  }
  return path;
}

constexpr glm::dvec3 kUtm{500123.4, 4650012.7, 230};

void expect_places(const GaussianCloud& cloud, const glm::dvec3& middle, double tolerance) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 world = cloud.origin + glm::dvec3(cloud.positions[i]);
    const glm::dvec3 expected = position_of(i, middle, 2);
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(world[axis], expected[axis], tolerance);
  }
}

TEST(Place, doubles_of_a_ply_keep_their_places) {
  const TemporaryFolder folder;
  const Scene scene = read_scene(write_ply_of(folder / "a.ply", "double", kUtm));
  EXPECT_EQ(scene.cloud.origin, glm::dvec3(500120, 4650010, 230));
  expect_places(scene.cloud, kUtm, 1e-6);
  write_scene(scene.cloud, folder / "b.ply");
  expect_places(read_scene(folder / "b.ply").cloud, kUtm, 1e-6);
  write_trained_scene(scene.cloud, folder / "c.ply", *std::make_unique<ThreadPool>(1));
  const Scene trained = read_scene(folder / "c.ply");
  EXPECT_EQ(trained.cloud.origin, scene.cloud.origin);
  EXPECT_EQ(trained.cloud.positions, scene.cloud.positions);
}

TEST(Place, data_near_0_stays_where_it_is) {
  const TemporaryFolder folder;
  for (const char* type : {"double", "float"}) {
    const Scene scene = read_scene(write_ply_of(folder / "a.ply", type, {3, -400, 70}));
    EXPECT_EQ(scene.cloud.origin, glm::dvec3(0));
    for (std::size_t i = 0; i < scene.cloud.size(); ++i)
      EXPECT_EQ(scene.cloud.positions[i], glm::vec3(position_of(i, {3, -400, 70}, 2)));
  }
}

TEST(Place, axes_turn_the_origin_too) {
  const TemporaryFolder folder;
  ReadOptions options;
  options.axes = "RUB";
  const Scene scene = read_scene(write_ply_of(folder / "a.ply", "double", kUtm), options);
  EXPECT_EQ(scene.cloud.origin, glm::dvec3(500120, -4650010, -230));
}

TEST(Place, a_comment_names_the_origin) {
  const TemporaryFolder folder;
  const Scene scene = read_scene(
      write_ply_of(folder / "a.ply", "float", {1, 2, 3}, "comment offset 500000 4650000 200\n"));
  EXPECT_EQ(scene.cloud.origin, glm::dvec3(500000, 4650000, 200));
  expect_places(scene.cloud, {500001, 4650002, 203}, 1e-5);
  const Scene wrong = read_scene(
      write_ply_of(folder / "a.ply", "float", {1, 2, 3}, "comment offset of the sensor\n"));
  EXPECT_EQ(wrong.cloud.origin, glm::dvec3(0));
}

TEST(Place, a_camera_counts_from_the_origin_of_its_scene) {
  const Camera world = look_at(kUtm + glm::dvec3(1, 2, -3), kUtm, {0, -1, 0}, 1, 40, 30);
  const Camera placed = world.placed({500000, 4650000, 200});
  const glm::dvec3 position = placed.position();
  EXPECT_NEAR(position.x, 124.4, 1e-6);
  EXPECT_NEAR(position.y, 14.7, 1e-6);
  EXPECT_NEAR(position.z, 27, 1e-6);
  // Its JSON says the origin, so that it is read back for any scene.
  const Camera read = parse_camera(format_camera(placed), "test");
  EXPECT_EQ(read.origin, placed.origin);
  EXPECT_EQ(read.view_from_world, placed.view_from_world);
  const glm::dvec3 other = read.placed({500100, 4650000, 0}).position();
  EXPECT_NEAR(other.x, 24.4, 1e-6);
  EXPECT_NEAR(other.z, 227, 1e-6);
  // Files without an origin belong beside their cameras.
  EXPECT_EQ(read.placed(glm::dvec3(0)).view_from_world, placed.view_from_world);
}

TEST(Place, strays_do_not_coarsen_the_steps_of_spz) {
  const TemporaryFolder folder;
  GaussianCloud cloud = read_scene(write_ply_of(folder / "a.ply", "float", {1, 2, 3})).cloud;
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < 6000; ++i) numbers.push_back(i % 60);
  const auto repeat = [&] {
    GaussianCloud all;
    all.resize(numbers.size(), cloud.sh_degree);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      all.positions[i] = cloud.positions[numbers[i]];
      all.log_scales[i] = cloud.log_scales[numbers[i]];
      all.rotations[i] = cloud.rotations[numbers[i]];
      all.opacity_logits[i] = cloud.opacity_logits[numbers[i]];
      all.sh[i] = cloud.sh[numbers[i]];
    }
    return all;
  };
  GaussianCloud all = repeat();
  all.positions[17] = {0, -90000, 0};
  const WriterRow& writer = write_scene(all, folder / "a.spz");
  const Scene read = read_scene(folder / "a.spz");
  EXPECT_NEAR(read.cloud.positions[17].y, -2048, 0.1);
  for (std::size_t i = 0; i < 17; ++i)
    EXPECT_NEAR(read.cloud.positions[i].x, all.positions[i].x, 1.0 / 8192 + 1e-6);
  EXPECT_THAT(writer.loss(all), HasSubstr("1 Gaussian beyond 2048"));
  EXPECT_EQ(writer.loss(repeat()), "");
  // More of them need a coarser step, which is said.
  for (std::size_t i = 0; i < 60; ++i) all.positions[i].y = -90000;
  write_scene(all, folder / "a.spz");
  EXPECT_NEAR(read_scene(folder / "a.spz").cloud.positions[17].y, -90000, 0.1);
  EXPECT_THAT(writer.loss(all), HasSubstr("steps of 0.0"));
}

}  // namespace
}  // namespace qs::test
