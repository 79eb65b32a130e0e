// SPDX-License-Identifier: MIT
// The library draws the bytes of the program, into any layout.
#include <algorithm>
#include <cstring>
#include <functional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/support/run_program.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "library/opened_scene.h"
#include "raster/api/renderer.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

constexpr int kWidth = 150, kHeight = 101;
constexpr const char* kSize = "150x101";
constexpr const char* kPipelines[] = {"fast", "classic"};

std::vector<std::string> names_of_modes() {
  std::vector<std::string> names;
  for (CullMode mode = 1; mode <= mode_count(); ++mode) names.emplace_back(mode_name(mode));
  return names;
}

/// A run of `quadsplat render` on the bundled scene, which must succeed.
void run_render(const std::vector<std::string>& more) {
  std::vector<std::string> words = {"render", test::plush().string(), "--backend", "cpu"};
  words.insert(words.end(), more.begin(), more.end());
  const test::ProgramRun run = test::run_quadsplat(words);
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

/// The values of a picture; fewer than four channels as stored.
std::vector<float> values_in(const std::filesystem::path& path) { return read_image(path).values; }

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

QsSettings settings_in(const std::string& mode, std::size_t pipeline) {
  QsSettings settings = QS_SETTINGS;
  settings.cull = mode.c_str();
  settings.pipeline = static_cast<std::uint32_t>(pipeline);
  return settings;
}

TEST(LibraryRender, draws_the_bytes_of_the_program_in_every_mode_and_pipeline) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const QsCamera camera = test::plush_camera(32, kWidth, kHeight);
  for (std::size_t pipeline = 0; pipeline < 2; ++pipeline) {
    const TemporaryFolder folder;
    for (const char* quantity : {"color", "alpha", "depth", "median-depth"}) {
      run_render({"--camera-index", "32", "--size", kSize, "--cull", "all,+peers", "--repeats", "1",
                  "--pipeline", kPipelines[pipeline], "--picture", quantity, "--output",
                  (folder / (std::string(quantity) + ".npy")).string()});
    }
    for (const std::string& mode : names_of_modes()) {
      SCOPED_TRACE(mode + " " + kPipelines[pipeline]);
      const test::Results results = test::rendered(scene, camera, settings_in(mode, pipeline));
      const auto file = [&](const std::string& quantity) {
        return values_in(folder / (quantity + "_" + mode + ".npy"));
      };
      EXPECT_TRUE(same_bits(results.color, file("color")));
      EXPECT_TRUE(same_bits(results.alpha, file("alpha")));
      EXPECT_TRUE(same_bits(results.depth, file("depth")));
      EXPECT_TRUE(same_bits(results.median_depth, file("median-depth")));
      EXPECT_EQ(results.counts.pipeline, pipeline);
    }
  }
}

TEST(LibraryRender, draws_the_bytes_of_the_program_in_mode_reference) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const QsCamera camera = test::plush_camera(0, 48, 32);
  const TemporaryFolder folder;
  for (const char* quantity : {"color", "depth"}) {
    run_render({"--camera-index", "0", "--size", "48x32", "--cull", "reference", "--picture",
                quantity, "--output", (folder / (std::string(quantity) + ".npy")).string()});
  }
  std::vector<float> color(48 * 32 * 3), depth(48 * 32);
  auto picture = quadsplat::sized<QsPicture>();
  picture.color = quadsplat::array_of(color.data(), {32, 48, 3});
  picture.depth = quadsplat::array_of(depth.data(), {32, 48});
  scene.render(camera, picture, settings_in("reference", 0));
  EXPECT_TRUE(same_bits(color, values_in(folder / "color.npy")));
  EXPECT_TRUE(same_bits(depth, values_in(folder / "depth.npy")));
}

TEST(LibraryRender, draws_the_8_bit_values_of_the_programs_pictures) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const QsCamera camera = test::plush_camera(5, kWidth, kHeight);
  const TemporaryFolder folder;
  run_render(
      {"--camera-index", "5", "--size", kSize, "--output", (folder / "picture.png").string()});
  const Image program = read_image(folder / "picture.png");
  std::vector<std::uint8_t> pixels(3 * kWidth * kHeight);
  auto picture = quadsplat::sized<QsPicture>();
  picture.color = quadsplat::array_of(pixels.data(), {kHeight, kWidth, 3});
  scene.render(camera, picture);
  std::size_t different = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i)
    different += pixels[i] == to_8bit(program.values[i]) ? 0 : 1;
  EXPECT_EQ(different, 0u);
}

TEST(LibraryRender, draws_the_bytes_of_the_program_with_every_setting) {
  struct Case {
    std::vector<std::string> options;
    std::function<void(QsSettings&)> change;
  };
  const Case cases[] = {
      {{"--background", "1,0.5,0.25"},
       [](QsSettings& s) { s.background[0] = 1, s.background[1] = 0.5f, s.background[2] = 0.25f; }},
      {{"--splat-scale", "0.5"}, [](QsSettings& s) { s.splat_scale = 0.5f; }},
      {{"--sh-degree", "0"}, [](QsSettings& s) { s.sh_degree = 0; }},
      {{"--antialiased", "on"}, [](QsSettings& s) { s.antialiased = QS_ANTIALIASED_ON; }},
      {{"--antialiased", "off"}, [](QsSettings& s) { s.antialiased = QS_ANTIALIASED_OFF; }},
      {{"--tile-size", "8"}, [](QsSettings& s) { s.tile_px = 8; }},
      {{"--tile-size", "32"}, [](QsSettings& s) { s.tile_px = 32; }},
  };
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const QsCamera camera = test::plush_camera(7, 80, 60);
  for (const Case& one : cases) {
    SCOPED_TRACE(one.options[0] + " " + one.options[1]);
    const TemporaryFolder folder;
    std::vector<std::string> words = {
        "--camera-index", "7", "--size", "80x60", "--output", (folder / "picture.npy").string()};
    words.insert(words.end(), one.options.begin(), one.options.end());
    run_render(words);
    QsSettings settings = QS_SETTINGS;
    one.change(settings);
    EXPECT_TRUE(
        same_bits(test::colors(scene, camera, settings), values_in(folder / "picture.npy")));
  }
}

TEST(LibraryRender, counts_as_the_statistics_of_the_program) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const QsCamera camera = test::plush_camera(32, kWidth, kHeight);
  const TemporaryFolder folder;
  run_render({"--camera-index", "32", "--size", kSize, "--cull", "all,+peers", "--repeats", "1",
              "--stats", (folder / "stats.json").string()});
  const auto stats = nlohmann::json::parse(test::content_of(folder / "stats.json"));
  ASSERT_EQ(stats["frames"].size(), static_cast<std::size_t>(mode_count()));
  for (const auto& frame : stats["frames"]) {
    const std::string mode = frame["mode"];
    SCOPED_TRACE(mode);
    const QsCounts counts = test::rendered(scene, camera, settings_in(mode, 0)).counts;
    EXPECT_EQ(counts.tile_pairs, frame["tile_pairs"].get<std::uint64_t>());
    EXPECT_EQ(counts.visible, frame["visible"].get<std::uint64_t>());
    EXPECT_EQ(counts.max_pairs_in_a_tile, frame["max_pairs_in_a_tile"].get<std::uint64_t>());
  }
}

TEST(LibraryRender, fills_maps_as_the_renderer) {
  const GaussianCloud cloud = test::random_cloud(3000, 2, 3);
  const Camera view = test::front_camera(90, 70);
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(cloud, {});
  Outputs outputs;
  outputs.pairs = outputs.evaluated = outputs.used = true;
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud));
  for (const int tile_px : {8, 16, 32}) {
    RenderSettings settings;
    settings.tile_px = tile_px;
    settings.dilation = 0.1;
    const Frame& frame = renderer->render(view, settings, outputs);
    QsSettings given = QS_SETTINGS;
    given.tile_px = tile_px;
    given.dilation_px2 = 0.1;
    const test::Results results = test::rendered(scene, test::c_camera(view), given);
    EXPECT_EQ(results.pairs, frame.pairs);
    EXPECT_EQ(results.used, frame.used);
    EXPECT_EQ(results.evaluated, frame.evaluated);
    EXPECT_EQ(results.counts.used_pairs, frame.stats.used_pairs.value());
    EXPECT_EQ(results.counts.tile_px, tile_px);
    EXPECT_EQ(results.counts.tile_columns, frame.grid.columns);
    EXPECT_EQ(results.counts.tile_rows, frame.grid.rows);
    EXPECT_EQ(results.counts.gaussians, cloud.size());
    EXPECT_TRUE(same_bits(results.color, frame.color.values));
  }
}

TEST(LibraryRender, stores_in_any_layout_and_writes_nothing_between_elements) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(test::random_cloud(2000, 1, 8)));
  const QsCamera camera = test::c_camera(test::front_camera(37, 23));
  const std::vector<float> usual = test::colors(scene, camera);
  const auto at = [&](int x, int y, int c) {
    return usual[static_cast<std::size_t>((y * 37 + x) * 3 + c)];
  };

  std::vector<float> planes(3 * 37 * 23);
  auto picture = quadsplat::sized<QsPicture>();
  picture.color = quadsplat::planes_of(planes.data(), 23, 37);
  scene.render(camera, picture);
  // Every second value of rows with 7 values between them, from the last row to the first.
  constexpr int kRow = 2 * 3 * 37 + 7;
  std::vector<float> spread(kRow * 23, 7.5f);
  picture.color = quadsplat::array_of(spread.data() + 22 * kRow, {23, 37, 3});
  picture.color.strides[0] = -kRow;
  picture.color.strides[1] = 6;
  picture.color.strides[2] = 2;
  scene.render(camera, picture);

  std::size_t wrong = 0;
  for (int y = 0; y < 23; ++y)
    for (int x = 0; x < 37; ++x)
      for (int c = 0; c < 3; ++c) {
        wrong += planes[static_cast<std::size_t>((c * 23 + y) * 37 + x)] != at(x, y, c);
        float& value = spread[static_cast<std::size_t>((22 - y) * kRow + 6 * x + 2 * c)];
        wrong += value != at(x, y, c);
        value = 7.5f;
      }
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(std::count(spread.begin(), spread.end(), 7.5f), kRow * 23);
}

template <class Integer>
void expect_pairs_as(quadsplat::Scene& scene, const QsCamera& camera,
                     const std::vector<std::uint32_t>& expected) {
  std::vector<Integer> pairs(expected.size());
  auto picture = quadsplat::sized<QsPicture>();
  picture.pairs = quadsplat::array_of(pairs.data(), {3, 4});
  scene.render(camera, picture);
  EXPECT_TRUE(std::equal(pairs.begin(), pairs.end(), expected.begin(), expected.end()));
}

TEST(LibraryRender, stores_integers_of_every_type) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(test::random_cloud(2000, 1, 8)));
  const QsCamera camera = test::c_camera(test::front_camera(60, 40));
  const std::vector<std::uint32_t> pairs = test::rendered(scene, camera).pairs;
  ASSERT_GT(*std::max_element(pairs.begin(), pairs.end()), 0u);
  expect_pairs_as<std::int32_t>(scene, camera, pairs);
  expect_pairs_as<std::int64_t>(scene, camera, pairs);
  expect_pairs_as<std::uint64_t>(scene, camera, pairs);
}

TEST(LibraryRender, draws_many_views_of_different_sizes_as_single_views) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  std::vector<QsCamera> cameras;
  std::vector<test::Results> results(4);
  std::vector<QsPicture> pictures;
  for (std::size_t i = 0; i < results.size(); ++i) {
    cameras.push_back(test::plush_camera(10 * i, 40 + 17 * static_cast<int>(i), 33));
    pictures.push_back(test::picture_of(results[i], cameras[i]));
  }
  scene.render(cameras, pictures);
  for (std::size_t i = 0; i < results.size(); ++i) {
    const test::Results single = test::rendered(scene, cameras[i]);
    EXPECT_TRUE(same_bits(results[i].color, single.color)) << i;
    EXPECT_TRUE(same_bits(results[i].depth, single.depth)) << i;
    EXPECT_EQ(results[i].used, single.used) << i;
    EXPECT_EQ(results[i].counts.tile_pairs, single.counts.tile_pairs) << i;
  }
  scene.render(std::vector<QsCamera>(), {});  // no view
}

TEST(LibraryRender, draws_through_lenses_as_the_program) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const struct {
    const char* model;
    std::vector<double> parameters;
    std::vector<std::string> options;
    int width, height;
  } cases[] = {
      {"OPENCV_FISHEYE",
       {60, 60, 75, 50.5, 0.05, -0.02, 0.004, -0.001},
       {"OPENCV_FISHEYE,150,101,60,60,75,50.5,0.05,-0.02,0.004,-0.001"},
       150,
       101},
      {"SIMPLE_RADIAL", {100, 60, 40, -0.2}, {"SIMPLE_RADIAL,120,80,100,60,40,-0.2"}, 120, 80},
      {"EUCM", {60, 60, 75, 50, 0.6, 1.1}, {"EUCM,150,100,60,60,75,50,0.6,1.1"}, 150, 100},
      {"FISHEYE", {40, 40, 60, 40}, {"FISHEYE,120,80,40,40,60,40"}, 120, 80},
      {"EQUIRECTANGULAR", {128, 64}, {"equirectangular"}, 128, 64},
      {"ORTHOGRAPHIC", {5}, {"orthographic", "--height", "5"}, 120, 80},
  };
  for (const auto& [model, parameters, options, width, height] : cases) {
    SCOPED_TRACE(model);
    const TemporaryFolder folder;
    for (const char* quantity : {"color", "alpha", "depth"}) {
      std::vector<std::string> words = {
          "--camera-index", "32",
          "--size",         fmt::format("{}x{}", width, height),
          "--repeats",      "1",
          "--picture",      quantity,
          "--output",       (folder / (std::string(quantity) + ".npy")).string(),
          "--lens"};
      words.insert(words.end(), options.begin(), options.end());
      run_render(words);
    }
    QsCamera camera = test::plush_camera(32, width, height);
    test::set_model(camera, model, parameters);
    for (int repeat = 0; repeat < 2; ++repeat) {
      test::Results results;
      QsPicture picture = test::picture_of(results, camera);
      picture.evaluated = picture.pairs = picture.used = QS_ABSENT;
      scene.render(camera, picture);
      EXPECT_TRUE(same_bits(results.color, values_in(folder / "color.npy")));
      EXPECT_TRUE(same_bits(results.alpha, values_in(folder / "alpha.npy")));
      EXPECT_TRUE(same_bits(results.depth, values_in(folder / "depth.npy")));
      EXPECT_GT(results.counts.tile_pairs, 0u);
    }
  }
}

TEST(LibraryRender, counts_alone_need_no_picture) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.load(test::plush().string());
  const QsCamera camera = test::plush_camera(0, kWidth, kHeight);
  auto counts = quadsplat::sized<QsCounts>();
  auto picture = quadsplat::sized<QsPicture>();
  picture.counts = &counts;
  scene.render(camera, picture);
  EXPECT_EQ(counts.tile_pairs, test::rendered(scene, camera).counts.tile_pairs);
  EXPECT_GT(counts.tile_pairs, 0u);
  EXPECT_EQ(counts.used_pairs, 0u);
  EXPECT_EQ(counts.stage_ms[QS_STAGE_BLEND], 0);
  scene.render(camera, quadsplat::sized<QsPicture>());  // nothing at all
}

TEST(LibraryRender, draws_the_background_of_a_scene_without_gaussians) {
  quadsplat::Context context = test::cpu();
  const GaussianCloud none;
  quadsplat::Scene scene = context.wrap(test::gaussians_of(none));
  EXPECT_EQ(scene.facts().gaussians, 0u);
  const QsCamera camera = test::c_camera(test::front_camera(17, 1));
  QsSettings settings = QS_SETTINGS;
  settings.background[1] = 0.25f;
  for (const std::string& mode : names_of_modes()) {
    for (std::uint32_t pipeline = 0; pipeline < 2; ++pipeline) {
      settings.cull = mode.c_str();
      settings.pipeline = pipeline;
      const test::Results results = test::rendered(scene, camera, settings);
      for (std::size_t i = 0; i < results.color.size(); ++i)
        ASSERT_EQ(results.color[i], i % 3 == 1 ? 0.25f : 0.0f) << mode;
      EXPECT_EQ(results.counts.tile_pairs, 0u);
      EXPECT_EQ(results.alpha, std::vector<float>(17, 0.0f));
    }
  }
}

TEST(LibraryRender, honours_the_near_plane) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene =
      context.wrap(test::gaussians_of(test::single_gaussian({0, 0, 2}, 0.3f, {1, 1, 1}, 3)));
  QsCamera camera = test::c_camera(test::front_camera(20, 20));
  EXPECT_EQ(test::rendered(scene, camera).counts.visible, 1u);
  camera.near_depth = 2;
  EXPECT_EQ(test::rendered(scene, camera).counts.visible, 0u);
  camera.near_depth = 0;
  EXPECT_EQ(test::rendered(scene, camera).counts.visible, 1u);
}

}  // namespace
}  // namespace qs
