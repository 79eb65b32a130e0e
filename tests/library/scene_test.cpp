// SPDX-License-Identifier: MIT
// Scenes of files and of the caller's arrays.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <utility>

#include "library/opened_scene.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/image.h"
#include "support/error_of.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

const QsCamera& camera() {
  static const QsCamera kCamera = test::plush_camera(32, 120, 90);
  return kCamera;
}

/// Arrays in double precision, with 3 unused values behind every row and an order of dimensions
/// that differs from the sizes.
struct SpreadOut {
  std::vector<double> means, scales, rotations, opacities, colors;
  test::CloudArrays gaussians;

  explicit SpreadOut(const GaussianCloud& cloud) : gaussians(test::gaussians_of(cloud)) {
    for (auto [array, values] : {std::pair{&gaussians.means, &means},
                                 {&gaussians.scales, &scales},
                                 {&gaussians.rotations, &rotations},
                                 {&gaussians.opacities, &opacities},
                                 {&gaussians.colors, &colors}}) {
      spread(*array, *values);
    }
  }

  // The last dimension becomes the slowest.
  static void spread(QsArray& array, std::vector<double>& values) {
    const QsArray from = array;
    std::int64_t next = 1;
    for (std::uint32_t i = 0; i < array.dimensions; ++i) {
      array.strides[i] = next;
      next *= array.sizes[i] + 3;
    }
    values.assign(static_cast<std::size_t>(next), -77.0);
    const std::int64_t rows = from.sizes[0], columns = from.dimensions > 1 ? from.sizes[1] : 1,
                       depth = from.dimensions > 2 ? from.sizes[2] : 1;
    for (std::int64_t i = 0; i < rows; ++i)
      for (std::int64_t j = 0; j < columns; ++j)
        for (std::int64_t k = 0; k < depth; ++k) {
          const auto place = [&](const QsArray& of) {
            return i * of.strides[0] + (of.dimensions > 1 ? j * of.strides[1] : 0) +
                   (of.dimensions > 2 ? k * of.strides[2] : 0);
          };
          values[static_cast<std::size_t>(place(array))] =
              static_cast<double>(static_cast<const float*>(from.data)[place(from)]);
        }
    array.data = values.data();
    array.type = QS_FLOAT64;
  }
};

TEST(LibraryScene, facts_are_the_files) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const Scene read = test::read_scene(test::plush());
  const QsSceneFacts facts = scene.facts();
  EXPECT_EQ(facts.gaussians, read.cloud.size());
  EXPECT_EQ(facts.not_drawn, 0u);
  EXPECT_EQ(facts.sh_degree, read.cloud.sh_degree);
  EXPECT_EQ(facts.file_bytes, read.file_bytes);
  EXPECT_EQ(facts.path, test::plush().string());
  EXPECT_EQ(facts.format, read.format);
  EXPECT_STREQ(facts.axes, "RDF");
  EXPECT_EQ(facts.cameras_path, test::plush_cameras().string());
  EXPECT_STREQ(facts.warnings, "");
  EXPECT_EQ(facts.antialiased, 0u);
  EXPECT_EQ(facts.white_background, 0u);
  for (int axis = 0; axis < 3; ++axis) {
    float low = kInfinity, high = -kInfinity;
    for (const glm::vec3& position : read.cloud.positions) {
      low = std::min(low, position[axis]);
      high = std::max(high, position[axis]);
    }
    EXPECT_EQ(facts.low[axis], low);
    EXPECT_EQ(facts.high[axis], high);
  }
}

TEST(LibraryScene, a_model_says_that_its_background_is_white) {
  const TemporaryFolder folder;
  const auto points = folder / "point_cloud/iteration_1";
  std::filesystem::create_directories(points);
  std::filesystem::copy_file(test::plush(), points / "point_cloud.ply");
  std::ofstream(folder / "cfg_args") << "Namespace(sh_degree=3, white_background=True)";
  EXPECT_EQ(test::cpu().load((folder / "").string()).facts().white_background, 1u);
}

TEST(LibraryScene, wrapped_draws_the_bytes_of_the_file) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene loaded = context.load(test::plush().string());
  const Scene read = test::read_scene(test::plush());
  quadsplat::Scene wrapped = context.wrap(test::gaussians_of(read.cloud));
  const SpreadOut doubles(read.cloud);
  quadsplat::Scene spread = context.wrap(doubles.gaussians);
  const std::vector<float> expected = test::colors(loaded, camera());
  EXPECT_EQ(test::colors(wrapped, camera()), expected);
  EXPECT_EQ(test::colors(spread, camera()), expected);
  EXPECT_STREQ(wrapped.facts().format, "memory");
  EXPECT_STREQ(wrapped.facts().path, "");
  EXPECT_STREQ(wrapped.facts().cameras_path, "");
}

TEST(LibraryScene, keeps_its_values_when_the_arrays_change) {
  quadsplat::Context context = test::cpu();
  GaussianCloud cloud = test::random_cloud(500, 1, 2);
  const QsCamera front = test::c_camera(test::front_camera(40, 30));
  quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud));
  cloud.positions.assign(500, glm::vec3(0, 0, 9));
  quadsplat::Scene before = context.wrap(test::gaussians_of(test::random_cloud(500, 1, 2)));
  EXPECT_EQ(test::colors(scene, front), test::colors(before, front));
}

TEST(LibraryScene, takes_dc_and_rest_in_two_arrays) {
  quadsplat::Context context = test::cpu();
  const GaussianCloud cloud = test::random_cloud(800, 3, 5);
  const QsCamera front = test::c_camera(test::front_camera(60, 40));
  const test::CloudArrays whole(cloud);
  QsGaussians parts = whole;
  parts.colors.sizes[1] = 1;
  parts.rest = whole.colors;
  parts.rest.sizes[1] = 15;
  parts.rest.data = static_cast<float*>(whole.colors.data) + 3;
  quadsplat::Scene one = context.wrap(whole), two = context.wrap(parts);
  EXPECT_EQ(two.facts().sh_degree, 3);
  EXPECT_EQ(test::colors(one, front), test::colors(two, front));
}

TEST(LibraryScene, activated_values_draw_the_same_within_rounding) {
  quadsplat::Context context = test::cpu();
  const Scene read = test::read_scene(test::plush());
  const GaussianCloud& cloud = read.cloud;
  std::vector<float> scales, opacities, rotations;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) scales.push_back(std::exp(cloud.log_scales[i][axis]));
    opacities.push_back(static_cast<float>(opacity_of_logit(cloud.opacity_logits[i])));
    const glm::quat q = 3.5f * cloud.rotations[i];  // of another length
    rotations.insert(rotations.end(), {q.w, q.x, q.y, q.z});
  }
  const auto count = static_cast<std::int64_t>(cloud.size());
  test::CloudArrays given(cloud);
  quadsplat::Scene raw = context.wrap(given);
  given.is_activated = 1;
  given.scales = quadsplat::array_of(scales.data(), {count, 3});
  given.opacities = quadsplat::array_of(opacities.data(), {count});
  given.rotations = quadsplat::array_of(rotations.data(), {count, 4});
  quadsplat::Scene activated = context.wrap(given);
  const std::vector<float> a = test::colors(raw, camera()), b = test::colors(activated, camera());
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    squares += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2);
  EXPECT_LT(squares / static_cast<double>(a.size()), 1e-8);  // 80 dB
}

TEST(LibraryScene, activated_ends_are_drawn) {
  quadsplat::Context context = test::cpu();
  // Opacity 1 and a flat Gaussian, then opacity 0.
  const float means[] = {0, 0, 2, 0, 0, 1}, scales[] = {0.5f, 0.5f, 0, 0.1f, 0.1f, 0.1f};
  const float rotations[] = {1, 0, 0, 0, 0, 0, 0, 9}, opacities[] = {1, 0};
  const float rgb[] = {1, 0.5f, 0, 1, 1, 1};
  auto given = quadsplat::sized<QsGaussians>();
  given.is_activated = 1;
  given.colors_are = QS_COLORS_RGB;
  given.means = quadsplat::array_of(means, {2, 3});
  given.scales = quadsplat::array_of(scales, {2, 3});
  given.rotations = quadsplat::array_of(rotations, {2, 4});
  given.opacities = quadsplat::array_of(opacities, {2});
  given.colors = quadsplat::array_of(rgb, {2, 3});
  quadsplat::Scene scene = context.wrap(given);
  EXPECT_EQ(scene.facts().not_drawn, 0u);
  const std::vector<float> image = test::colors(scene, test::c_camera(test::front_camera(21, 21)));
  const float* const middle = image.data() + (10 * 21 + 10) * 3;
  EXPECT_NEAR(middle[0], 0.99f, 1e-3);  // the largest alpha
  EXPECT_NEAR(middle[1], 0.495f, 1e-3);
  EXPECT_EQ(middle[2], 0.0f);
}

TEST(LibraryScene, does_not_draw_impossible_gaussians_and_draws_all_others) {
  struct Case {
    const char* what;
    std::function<void(GaussianCloud&)> spoil;
  };
  const Case cases[] = {
      {"position NaN", [](GaussianCloud& c) { c.positions[1].x = kNaN; }},
      {"position infinite", [](GaussianCloud& c) { c.positions[1].z = kInfinity; }},
      {"scale NaN", [](GaussianCloud& c) { c.log_scales[1].y = kNaN; }},
      {"scale infinite", [](GaussianCloud& c) { c.log_scales[1].y = kInfinity; }},
      {"rotation of length 0",
       [](GaussianCloud& c) {
         c.rotations[1] = {0, 0, 0, 0};
       }},
      {"rotation NaN", [](GaussianCloud& c) { c.rotations[1].w = kNaN; }},
      {"opacity NaN", [](GaussianCloud& c) { c.opacity_logits[1] = kNaN; }},
      {"colour NaN", [](GaussianCloud& c) { c.sh[1].g = kNaN; }},
      {"colour infinite", [](GaussianCloud& c) { c.sh[1].b = -kInfinity; }},
  };
  quadsplat::Context context = test::cpu();
  const QsCamera front = test::c_camera(test::front_camera(30, 20));
  GaussianCloud two = test::single_gaussian({0, 0, 2}, 0.2f, {1, 0, 0}, 2);
  const GaussianCloud one = two;
  test::append(two, test::single_gaussian({0, 0, 1}, 0.4f, {0, 1, 0}, 2));
  quadsplat::Scene alone = context.wrap(test::gaussians_of(one));
  const std::vector<float> expected = test::colors(alone, front);
  for (const Case& bad : cases) {
    GaussianCloud spoilt = two;
    bad.spoil(spoilt);
    quadsplat::Scene scene = context.wrap(test::gaussians_of(spoilt));
    EXPECT_EQ(scene.facts().not_drawn, 1u) << bad.what;
    EXPECT_EQ(scene.facts().gaussians, 2u) << bad.what;
    for (const char* mode : {"3dgs", "quadbox", "reference"}) {
      QsSettings settings = QS_SETTINGS;
      settings.cull = mode;
      EXPECT_EQ(test::colors(scene, front, settings), test::colors(alone, front, settings))
          << bad.what;
    }
  }
  GaussianCloud none = two;
  for (glm::vec3& position : none.positions) position.x = kNaN;
  quadsplat::Scene nothing = context.wrap(test::gaussians_of(none));
  EXPECT_EQ(nothing.facts().not_drawn, 2u);
  EXPECT_EQ(test::colors(nothing, front), std::vector<float>(30 * 20 * 3, 0.0f));
}

TEST(LibraryScene, activated_values_outside_of_their_range_are_not_drawn) {
  quadsplat::Context context = test::cpu();
  const float means[] = {0, 0, 2, 0, 0, 2, 0, 0, 2};
  const float scales[] = {0.1f, 0.1f, 0.1f, -0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f};
  const float rotations[] = {1, 0, 0, 0}, opacities[] = {1.25f, 0.5f, -0.5f}, rgb[] = {1, 1, 1};
  auto given = quadsplat::sized<QsGaussians>();
  given.is_activated = 1;
  given.colors_are = QS_COLORS_RGB;
  given.means = quadsplat::array_of(means, {3, 3});
  given.scales = quadsplat::array_of(scales, {3, 3});
  given.rotations = quadsplat::array_of(rotations, {3, 4});
  given.rotations.strides[0] = 0;  // all have the same rotation
  given.opacities = quadsplat::array_of(opacities, {3});
  given.colors = quadsplat::array_of(rgb, {3, 3});
  given.colors.strides[0] = 0;
  quadsplat::Scene scene = context.wrap(given);
  EXPECT_EQ(scene.facts().not_drawn, 3u);
}

TEST(LibraryScene, of_every_written_format_is_loaded) {
  const TemporaryFolder folder;
  quadsplat::Context context = test::cpu();
  const GaussianCloud cloud = test::random_cloud(300, 1, 3);
  for (const WriterRow& row : writers()) {
    const std::filesystem::path path = folder / (std::string("scene") + row.extension);
    test::write_scene(cloud, path, {}, row.name);
    quadsplat::Scene scene = context.load(path.string());
    EXPECT_GT(scene.facts().gaussians, 200u) << row.name;
    EXPECT_NE(std::string(scene.facts().format), "") << row.name;
  }
}

TEST(LibraryScene, has_other_axes_if_asked) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string(), "RUB");
  ReadOptions options;
  options.axes = "RUB";
  const Scene read = test::read_scene(test::plush(), options);
  EXPECT_STREQ(scene.facts().axes, "RUB");
  quadsplat::Scene same = context.wrap(test::gaussians_of(read.cloud));
  EXPECT_EQ(test::colors(scene, camera()), test::colors(same, camera()));
}

TEST(LibraryScene, files_that_cannot_be_read_have_the_sentences_of_the_program) {
  quadsplat::Context context = test::cpu();
  const TemporaryFolder folder;
  test::write_scene(test::random_cloud(3, 0, 1), folder / "short.ply");
  std::filesystem::resize_file(folder / "short.ply",
                               std::filesystem::file_size(folder / "short.ply") - 5);
  for (const char* name : {"missing.ply", "short.ply"}) {
    const std::string path = (folder / name).string();
    EXPECT_EQ(test::sentence_of([&] { context.load(path); }, QS_INPUT),
              test::error_of([&] { test::read_scene(path); }, ErrorKind::input));
  }
  EXPECT_EQ(test::sentence_of([&] { context.load(folder.path().string()); }, QS_INPUT),
            test::error_of([&] { test::read_scene(folder.path()); }, ErrorKind::input));
  EXPECT_EQ(test::sentence_of([&] { context.load(test::plush().string(), "XYZ"); }, QS_USAGE),
            "axes: 'XYZ' is no right-handed frame of three letters for x, y, z: R or L, D or U, B "
            "or F");
}

TEST(LibraryScene, warnings_of_the_file_are_facts) {
  quadsplat::Context context = test::cpu();
  const TemporaryFolder folder;
  GaussianCloud cloud = test::random_cloud(30, 0, 1);
  cloud.positions[3].x = kNaN;
  test::write_scene(cloud, folder / "nan.ply");
  quadsplat::Scene scene = context.load((folder / "nan.ply").string());
  EXPECT_EQ(scene.facts().gaussians, 29u);
  EXPECT_STREQ(scene.facts().warnings,
               "1 of 30 Gaussians were dropped for a position that is NaN, infinite or beyond "
               "1e19.");
}

}  // namespace
}  // namespace qs
