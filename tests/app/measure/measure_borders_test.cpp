// SPDX-License-Identifier: MIT
//
// Measurements at their borders: ties, single values, the first and the last pixel, exact sentences
// and tables.
#include <array>
#include <cmath>
#include <fstream>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/framing/scene_box.h"
#include "app/measure/camera_path.h"
#include "app/measure/load_times.h"
#include "app/measure/measure.h"
#include "app/measure/measure_view.h"
#include "app/measure/replicate.h"
#include "app/measure/scene_facts.h"
#include "app/measure/shard.h"
#include "app/measure/statistics.h"
#include "base/error.h"
#include "io/bytes/file_hash.h"
#include "io/camera/cameras.h"
#include "io/camera/lens_views.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::error_of;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(Statistics, spread_and_drift_of_ties_and_of_few_values) {
  EXPECT_EQ(relative_spread({}), 0);
  EXPECT_DOUBLE_EQ(relative_spread(std::array{1.0, 3.0}), 1);
  EXPECT_DOUBLE_EQ(relative_spread(std::array{2.0, 2.0}), 0);
  EXPECT_DOUBLE_EQ(relative_spread(std::array{0.0, 0.0, 5.0}), 0);  // a median of 0
  EXPECT_DOUBLE_EQ(summarise(std::array{0.0, 0.0, 4.0, 4.0}).drift, 0);
  EXPECT_DOUBLE_EQ(summarise(std::array{2.0, 3.0}).drift, 0.5);
  EXPECT_DOUBLE_EQ(percentile(std::array{5.0}, 1), 5);
  EXPECT_DOUBLE_EQ(percentile(std::array{1.0, 1.0, 3.0}, 0.75), 2);
}

BenchRow noisy_row(double drift, double spread) {
  BenchRow row;
  row.scene = "s";
  row.camera = "7";
  row.mode = "m";
  row.drift = drift;
  row.round_spread = spread;
  return row;
}

TEST(Noise, sentences_are_exact_at_the_tolerance_and_for_ties) {
  EXPECT_EQ(noise_sentence({noisy_row(kNoiseTolerance, -1), noisy_row(0, kNoiseTolerance)}), "");
  EXPECT_EQ(noise_sentence({noisy_row(0, 0), noisy_row(-0.25, 0.25)}),
            "1 of 2 rows are noisy: the worst is s, camera 7, m: its later frames took "
            "-25.0 % of the earlier ones' time, so the clock or the load changed: warm up or "
            "measure longer");
  EXPECT_EQ(noise_sentence({noisy_row(0.125, 0.25)}),
            "1 of 1 rows are noisy: the worst is s, camera 7, m: the medians of its "
            "rounds differ by 25.0 %, so the machine was not at rest or the rounds are too short");
  EXPECT_THAT(noise_markdown({noisy_row(0.125, 0.25)}),
              HasSubstr("| s | 7 | `m` | 0 % | +12.5 % | 25.0 % |\n"));
}

TEST(Shard, numbers_are_accepted_up_to_their_limits) {
  const auto parsed = [](const char* text) {
    const Shard shard = parse_shard("--shard", text);
    return std::pair(shard.index, shard.count);
  };
  EXPECT_EQ(parsed("1/1"), std::pair(1, 1));
  EXPECT_EQ(parsed("100000/100000"), std::pair(100000, 100000));
  EXPECT_EQ(error_of([&] { parsed("1/100001"); }),
            "--shard: '100001' is not a whole number from 1 to 100000");
  EXPECT_EQ(error_of([&] { parsed("3/2"); }), "--shard: '3' is not a whole number from 1 to 2");
  EXPECT_EQ(error_of([&] { parsed("0/2"); }), "--shard: '0' is not a whole number from 1 to 2");
  EXPECT_EQ(error_of([&] { parsed("7"); }), "--shard: '7' is not I/N, for example 1/4");
}

// ---- modes on one view --------------------------------------------------------------------------
// Reports the times of a list as the times of its frames, and counts calls.
class Clockwork : public Renderer {
 public:
  explicit Clockwork(std::vector<float> times_ms) : times_ms_(std::move(times_ms)) {}
  void upload(std::shared_ptr<const GaussianCloud>, const Progress&) override {}
  const Frame& render(const Camera&, const RenderSettings& settings, const Outputs& outputs,
                      const Target&, std::stop_token) override {
    const float ms = times_ms_[modes.size() % times_ms_.size()];
    frame_.stats.frame_ms = ms;
    for (int stage = 0; stage < kStageCount; ++stage)
      frame_.stats.stage_ms[stage] = static_cast<float>(stage + 1) * ms;
    frame_.stats.tile_pairs = 0;
    if (outputs.used) frame_.stats.used_pairs = 0;
    modes.push_back(settings.mode);
    stage_times.push_back(outputs.stage_times);
    return frame_;
  }
  std::vector<CullMode> modes;
  std::vector<bool> stage_times;

 private:
  std::vector<float> times_ms_;
  Frame frame_;
};

TEST(MeasureModes, modes_take_turns_and_progress_counts_them) {
  Clockwork renderer({9, 8, 1, 2, 3, 4, 5, 6});
  const std::array<CullMode, 2> modes = {3, 1};
  std::vector<float> reported;
  MeasurePlan plan{modes, 1, 3, HostImage{}, {[&](float done) { reported.push_back(done); }, {}}};
  std::vector<CullMode> visited;
  const auto results = measure_modes(renderer, test::front_camera(8, 6), {}, {}, plan,
                                     [&](CullMode mode, const Frame&) { visited.push_back(mode); });
  EXPECT_THAT(renderer.modes, ElementsAre(3, 1, 3, 1, 3, 1, 3, 1));
  EXPECT_THAT(visited, ElementsAre(3, 1));  // in the order of the plan, before the measured rounds
  EXPECT_THAT(reported, ElementsAre(0, 0.125f, 0.25f, 0.375f, 0.5f, 0.625f, 0.75f, 0.875f));
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].mode, 3);
  EXPECT_THAT(results[0].frame_ms, ElementsAre(1, 3, 5));
  EXPECT_EQ(results[0].stats.frame_ms, 3);
  EXPECT_THAT(results[1].frame_ms, ElementsAre(2, 4, 6));
  EXPECT_EQ(results[1].stats.frame_ms, 4);
}

// The number of times that a mode followed another: [before][after].
std::array<std::array<int, 10>, 10> follows_of(const std::vector<CullMode>& modes) {
  std::array<std::array<int, 10>, 10> follows{};
  for (std::size_t i = 1; i < modes.size(); ++i)
    ++follows[static_cast<std::size_t>(modes[i - 1])][static_cast<std::size_t>(modes[i])];
  return follows;
}

TEST(MeasureModes, every_mode_follows_every_other_about_equally_often) {
  for (CullMode count = 2; count <= 6; ++count) {
    std::vector<CullMode> modes;
    for (CullMode mode = 1; mode <= count; ++mode) modes.push_back(mode);
    Clockwork renderer({1});
    const auto nothing = [](CullMode, const Frame&) {};
    measure_modes(renderer, test::front_camera(8, 6), {}, {}, {modes, 20, 100, HostImage{}, {}},
                  nothing);
    const auto follows = follows_of(renderer.modes);
    for (CullMode before = 1; before <= count; ++before) {
      for (CullMode after = 1; after <= count; ++after) {
        const int times =
            follows[static_cast<std::size_t>(before)][static_cast<std::size_t>(after)];
        const int even = 120 / (count - 1);
        EXPECT_NEAR(times, before == after ? 0 : even, before == after ? 0 : 2) << count;
      }
    }
    for (std::size_t i = 0; i < renderer.modes.size(); i += modes.size()) {  // each once per round
      std::vector<CullMode> round(
          renderer.modes.begin() + static_cast<std::ptrdiff_t>(i),
          renderer.modes.begin() + static_cast<std::ptrdiff_t>(i + modes.size()));
      std::sort(round.begin(), round.end());
      ASSERT_EQ(round, modes);
    }
    Clockwork again({1});
    measure_modes(again, test::front_camera(8, 6), {}, {}, {modes, 20, 100, HostImage{}, {}},
                  nothing);
    EXPECT_EQ(again.modes, renderer.modes);
  }
}

TEST(MeasureView, the_order_changes_over_rounds_of_one_frame_and_over_views) {
  const std::vector<CullMode> modes = {1, 2, 3, 4, 5, 6};
  const auto order_of = [&](ViewPlan plan) {
    auto clockwork = std::make_unique<Clockwork>(std::vector<float>{2});
    const auto& renderer = *clockwork;
    Session session;
    session.renderer = std::move(clockwork);
    plan.details = false;
    measure_view(session, modes, test::front_camera(8, 6), plan, {});
    return renderer.modes;
  };
  const std::vector<CullMode> rounds = order_of({1, 0, 40});  // as the window measures
  const auto follows = follows_of(rounds);
  for (std::size_t before = 1; before <= 6; ++before) {
    for (std::size_t after = 1; after <= 6; ++after) {
      if (before == after) continue;
      EXPECT_NEAR(follows[before][after], 8, 2) << before << " " << after;
    }
  }
  EXPECT_EQ(order_of({1, 0, 1}), modes);
  ViewPlan second{1, 0, 1};
  second.first_round = 1;
  EXPECT_EQ(order_of(second), std::vector<CullMode>(rounds.begin() + 6, rounds.begin() + 12));
  EXPECT_NE(order_of(second), modes);
}

TEST(MeasureModes, one_mode_takes_every_turn) {
  Clockwork renderer({9, 1, 2});
  const std::array<CullMode, 1> modes = {5};
  const auto results = measure_modes(renderer, test::front_camera(8, 6), {}, {},
                                     {modes, 1, 2, HostImage{}, {}}, [](CullMode, const Frame&) {});
  EXPECT_THAT(renderer.modes, ElementsAre(5, 5, 5));
  EXPECT_THAT(results[0].frame_ms, ElementsAre(1, 2));
}

TEST(MeasureModes, stage_times_are_medians_of_extra_frames) {
  Clockwork renderer({5, 1, 2});
  ModeResult result;
  result.mode = 4;
  mark_stages(renderer, test::front_camera(8, 6), {}, {3}, result);
  EXPECT_THAT(renderer.modes, ElementsAre(4, 4, 4));
  EXPECT_THAT(renderer.stage_times, ElementsAre(true, true, true));
  EXPECT_EQ(result.marked_frame_ms, 2);
  for (int stage = 0; stage < kStageCount; ++stage)
    EXPECT_EQ(result.stats.stage_ms[stage], 2 * (stage + 1));
}

TEST(MeasureView, rounds_are_counted_and_a_view_without_pairs_has_no_share) {
  Session session;
  session.renderer = std::make_unique<Clockwork>(std::vector<float>{2});
  std::vector<float> reported;
  const auto rows = measure_view(session, {1}, test::front_camera(8, 6), {2, 0, 4},
                                 {[&](float done) { reported.push_back(done); }, {}});
  EXPECT_THAT(reported, ElementsAre(0, 0.125f, 0.25f, 0.375f, 0.5f, 0.625f, 0.75f, 0.875f));
  EXPECT_EQ(rows[0].false_positives, 0u);
  EXPECT_EQ(rows[0].false_positive_share, 0);
  EXPECT_EQ(rows[0].fps_median, 500);
  EXPECT_EQ(rows[0].frame_ms, 2);
  EXPECT_EQ(rows[0].preprocess_ms, 2);
  EXPECT_EQ(rows[0].bin_ms, 4);
  EXPECT_EQ(rows[0].sort_ms, 6);
  EXPECT_EQ(rows[0].blend_ms, 8);
}

TEST(PaperTimes, are_of_one_mode_after_the_other_behind_five_views_to_warm_up) {
  // Two rounds of two modes: 5 frames to warm up and 3 views each.
  auto clockwork = std::make_unique<Clockwork>(
      std::vector<float>{90, 90, 90, 90, 90, 1, 2, 3, 90, 90, 90, 90, 90, 4, 5, 6,
                         90, 90, 90, 90, 90, 3, 4, 5, 90, 90, 90, 90, 90, 6, 7, 8});
  const auto& renderer = *clockwork;
  Session session;
  session.renderer = std::move(clockwork);
  const std::vector<Camera> views(3, test::front_camera(8, 6));
  const auto times = paper_times(session, {2, 5}, views, 2, {});
  ASSERT_EQ(times.size(), 2u);
  EXPECT_THAT(times[0], ElementsAre(2, 3, 4));
  EXPECT_THAT(times[1], ElementsAre(5, 6, 7));
  std::vector<CullMode> modes(8, 2);
  modes.insert(modes.end(), 8, 5);
  modes.insert(modes.end(), modes.begin(), modes.begin() + 16);
  EXPECT_EQ(renderer.modes, modes);
  EXPECT_THAT(paper_times(session, {2}, {}, 1, {}), ElementsAre(testing::IsEmpty()));
}

TEST(ModeTable, its_first_line_names_the_columns) {
  std::vector<ModeResult> results(1);
  results[0].mode = find_culler("adr");
  const std::string text = format_mode_table(results);
  EXPECT_EQ(
      text.substr(0, text.find('\n')),
      "mode                           ms      FPS         pairs  pairs/visible             vs "
      "3dgs  what it is");
  EXPECT_THAT(text,
              HasSubstr("\nadr                         0.000      0.0             0           0.00"
                        "                   -  "));
  results[0].psnr = INFINITY;
  EXPECT_THAT(format_mode_table(results), HasSubstr("vs 3dgs  PSNR dB  what it is\n"));
}

TEST(LoadTimes, an_unpacked_file_has_no_time_of_inflating) {
  EXPECT_EQ(format_load_times({{"a.ply", "ply", 2, 5, 30, 10, 15, 8, 0}}),
            "| file | format | size | Gaussians | load ms | unpack ms | fill ms | copy ms | "
            "load/copy | inflate ms | load/inflate |\n"
            "|---|---|---|---|---|---|---|---|---|---|---|\n"
            "| a.ply | ply | 5 bytes | 2 | 30.0 | 10.0 | 15.0 | 8.0 | 3.75 | - | - |\n");
}

// ---- files --------------------------------------------------------------------------------------
TEST(SceneFacts, hash_and_names_are_those_of_the_file) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a.b.ply") << "123456789";
  EXPECT_EQ(file_hash(folder / "a.b.ply"), "crc32:cbf43926");
  std::ofstream(folder / "empty") << "";
  EXPECT_EQ(file_hash(folder / "empty"), "crc32:00000000");
  std::ofstream(folder / "long") << std::string((1 << 20) + 5, 'x');
  std::uint32_t expected = 0xffffffff;  // bit by bit
  for (int i = 0; i < (1 << 20) + 5; ++i) {
    expected ^= 'x';
    for (int bit = 0; bit < 8; ++bit)
      expected = (expected >> 1) ^ ((expected & 1) != 0 ? 0xedb88320 : 0);
  }
  char text[20];
  std::snprintf(text, sizeof text, "crc32:%08x", expected ^ 0xffffffff);
  EXPECT_EQ(file_hash(folder / "long"), text);
  EXPECT_EQ(scene_name("x/a.b.ply"), "a.b");
  EXPECT_EQ(scene_name("/data/garden/point_cloud/iteration_7/point_cloud.ply"), "garden");
  EXPECT_EQ(picture_title("x/a.ply", "camera 3"), "a \u00b7 camera 3");
  Scene scene;
  scene.path = folder / "a.b.ply";
  scene.file_bytes = 77;
  scene.cloud = test::random_cloud(3, 0, 1);
  EXPECT_EQ(scene_facts(scene, "n").dump(),
            R"({"name":"n","file":")" + scene.path.string() +
                R"(","hash":"crc32:cbf43926","bytes":77,"gaussians":3})");
}

// ---- paths --------------------------------------------------------------------------------------
Keyframe key(double time, double x, double focal) {
  Camera camera = test::front_camera(64, 48);
  camera.view_from_world[3].x = -x;
  camera.focal_px = {focal, 2 * focal};
  camera.center_px = {x, 3 * x};
  return {time, camera};
}

TEST(CameraPath, is_the_cubic_with_catmull_rom_slopes_over_uneven_times) {
  const std::vector<Keyframe> keyframes = {key(0, 0, 10), key(1, 1, 20), key(3, 4, 10),
                                           key(6, 9, 40)};
  // b + c at the middle of an interval weigh a half each, the slopes 1/8 and -1/8 of its length.
  const auto middle = [](double b, double c, double slope_b, double slope_c, double span) {
    return (b + c) / 2 + span * (slope_b - slope_c) / 8;
  };
  const auto x_at = [&](double time) { return camera_at(keyframes, time).position().x; };
  EXPECT_NEAR(x_at(0.5), middle(0, 1, 1, 4 / 3.0, 1), 1e-12);
  EXPECT_NEAR(x_at(2), middle(1, 4, 4 / 3.0, 8 / 5.0, 2), 1e-12);
  EXPECT_NEAR(x_at(4.5), middle(4, 9, 8 / 5.0, 5 / 3.0, 3), 1e-12);
  // A quarter into the second interval: Hermite's polynomials at 1/4.
  EXPECT_NEAR(x_at(1.5), 27 / 32.0 * 1 + 5 / 32.0 * 4 + 2 * (9 / 64.0 * 4 / 3 - 3 / 64.0 * 8 / 5),
              1e-12);
  const Camera camera = camera_at(keyframes, 2);
  const double doubling = std::log(2.0);
  EXPECT_NEAR(std::log(camera.focal_px.x / 10),
              middle(doubling, 0, 0, (2 * doubling - doubling) / 5, 2), 1e-12);
  EXPECT_NEAR(camera.focal_px.y, 2 * camera.focal_px.x, 1e-9);
  EXPECT_NEAR(camera.center_px.x, camera.position().x, 1e-12);
  EXPECT_NEAR(camera.center_px.y, 3 * camera.center_px.x, 1e-12);
  EXPECT_EQ(camera.width, 64);
  EXPECT_NEAR(x_at(-3), 0, 1e-12);
  EXPECT_NEAR(x_at(99), 9, 1e-12);
  EXPECT_NEAR(sample_path(keyframes, 1)[0].position().x, 0, 1e-12);
  EXPECT_NEAR(sample_path(keyframes, 4)[1].position().x, x_at(2), 1e-12);
}

TEST(CameraPath, turns_the_short_way) {
  std::vector<Keyframe> keyframes;
  for (const double degrees : {0.0, 120.0, 240.0, 350.0}) {
    const double a = glm::radians(degrees);
    keyframes.push_back({static_cast<double>(keyframes.size()),
                         look_at({0, 0, 0}, {std::sin(a), 0, std::cos(a)}, {0, -1, 0}, 1, 64, 48)});
  }
  const glm::dvec3 half = view_axes(camera_at(keyframes, 1.5)).forward;
  EXPECT_NEAR(half.x, 0, 0.1);
  EXPECT_NEAR(half.z, -1, 0.1);
}

TEST(CameraPath, files_are_read_as_written_and_errors_name_the_keyframe) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    std::ofstream(folder / "path.json") << text;
    return read_camera_path(folder / "path.json");
  };
  const std::vector<Keyframe> keyframes = {key(0.5, 0, 10), key(1.75, 1, 20), key(3, 4, 10)};
  const std::vector<Keyframe> again = read(format_camera_path(keyframes));
  ASSERT_EQ(again.size(), 3u);
  EXPECT_EQ(again[1].time, 1.75);
  EXPECT_EQ(format_camera_path(again), format_camera_path(keyframes));
  const std::string camera = format_camera(test::front_camera(8, 6));
  const auto untimed = read("[" + camera + "," + camera + "," + camera + "]");
  EXPECT_EQ(untimed[0].time, 0);
  EXPECT_EQ(untimed[2].time, 2);
  const std::string path = (folder / "path.json").string();
  const auto error = [&](const std::string& text) { return error_of([&] { read(text); }); };
  EXPECT_EQ(error("[" + camera + "]"),
            path + ": is not a camera path: a list of at least two cameras");
  EXPECT_EQ(error("{}"), path + ": is not a camera path: a list of at least two cameras");
  const auto timed = [&](const char* time) {
    std::string text = camera;
    return text.insert(1, std::string("\"time\":") + time + ",");
  };
  EXPECT_EQ(error("[" + timed("2") + "," + timed("2") + "]"),
            path + ": keyframe 1: its time 2 is not after the one before");
  EXPECT_EQ(error("[" + timed("\"a\"") + "," + camera + "]"),
            path + ": keyframe 0: time is not a number");
  EXPECT_EQ(error("[" + timed("3") + "," + camera + "]"), "");
  EXPECT_EQ(read("[" + timed("3") + "," + camera + "]")[1].time, 4);
  std::filesystem::resize_file(folder / "path.json", (64 << 20) + 1);
  EXPECT_EQ(error_of([&] { read_camera_path(path); }),
            path + ": 67108865 bytes are more than the 67108864 that are read");
}

TEST(ZoomPath, the_first_and_the_last_pixel_belong_to_the_picture) {
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::single_gaussian({0, 0, 3}, 9, {1, 1, 1}, 8), {});
  const Camera camera = test::front_camera(50, 20);
  const auto point = [&](int x, int y) { return find_point(*renderer, camera, {}, {x, y}); };
  for (const glm::ivec2 pixel : {glm::ivec2(0, 0), {49, 0}, {0, 19}, {49, 19}, {33, 12}}) {
    const auto found = point(pixel.x, pixel.y);
    ASSERT_TRUE(found) << pixel.x << " " << pixel.y;
    EXPECT_NEAR(found->z, 3, 1e-5);
    EXPECT_NEAR(found->x, 3 * (pixel.x - camera.center_px.x) / camera.focal_px.x, 1e-5);
    EXPECT_NEAR(found->y, 3 * (pixel.y - camera.center_px.y) / camera.focal_px.y, 1e-5);
  }
  for (const glm::ivec2 pixel : {glm::ivec2(-1, 0), {0, -1}, {50, 0}, {0, 20}})
    EXPECT_FALSE(point(pixel.x, pixel.y));
}

TEST(ZoomPath, the_target_under_a_pixel_of_a_lens_is_what_the_lens_shows_there) {
  Camera camera = look_at({1, 2, 3}, {2, 2.5, 7}, {0, -1, 0}, 1, 90, 60);
  const glm::dmat3 world_from_view = glm::transpose(glm::dmat3(camera.view_from_world));
  const auto found = [&](const LensView& lens, glm::ivec2 pixel, glm::dvec3 in_view) {
    const glm::dvec3 at = camera.position() + world_from_view * in_view;
    const auto renderer = make_renderer(Backend::cpu, test::pool());
    renderer->upload(test::single_gaussian(glm::vec3(at), 0.2f, {1, 1, 1}, 8), {});
    RenderSettings settings;
    settings.lens = std::make_shared<const LensView>(lens);
    const auto point = find_point(*renderer, camera, settings, pixel);
    return point ? glm::length(*point - at) : 1e9;
  };
  for (const LensView& lens : {panorama_view(360), fisheye_view(220)}) {
    for (const glm::ivec2 pixel : {glm::ivec2(45, 30), {60, 30}, {20, 45}, {44, 5}}) {
      const auto ray = lens.sized({90, 60}).direction(pixel);
      ASSERT_TRUE(ray);
      EXPECT_LT(found(lens, pixel, 4.0 * glm::normalize(*ray)), 0.01) << lens.text << pixel.x;
    }
  }
  EXPECT_GT(found(fisheye_view(220), {1, 1}, {0, 0, 4}), 1e8) << "outside of the circle";
  // 60 px are 6 units.
  const glm::dvec3 right_and_up((70 - 44.5) / 10, (20 - 29.5) / 10, 5);
  EXPECT_LT(found(parallel_view(6), {70, 20}, right_and_up), 0.01);
}

TEST(ZoomPath, the_target_absorbs_the_second_half_of_the_light) {
  const Camera camera = test::front_camera(33, 33);
  const auto logit = [](double opacity) {
    return static_cast<float>(std::log(opacity / (1 - opacity)));
  };
  const auto depth = [&](double first, double second, double third) {
    GaussianCloud cloud = test::single_gaussian({0, 0, 3}, 5, {1, 1, 1}, logit(first));
    test::append(cloud, test::single_gaussian({0, 0, 2}, 5, {1, 1, 1}, logit(second)));
    test::append(cloud, test::single_gaussian({0, 0, 5}, 5, {1, 1, 1}, logit(third)));
    const auto renderer = make_renderer(Backend::cpu, test::pool());
    renderer->upload(cloud, {});
    const auto point = find_point(*renderer, camera, {}, {16, 16});
    return point ? point->z : 0;
  };
  EXPECT_NEAR(depth(0.2, 0.45, 0.9), 3, 1e-5);  // 0.55, then 0.44
  EXPECT_NEAR(depth(0.05, 0.45, 0.5), 5, 1e-5);
  EXPECT_NEAR(depth(0.2, 0.51, 0.5), 2, 1e-5);
  EXPECT_EQ(depth(0.2, 0.1, 0.3), 0);
  // Off its centre a Gaussian absorbs less.
  GaussianCloud cloud = test::single_gaussian({0, 0, 3}, 0.3f, {1, 1, 1}, logit(0.99));
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(cloud, {});
  const double sigma_px = std::sqrt(std::pow(0.3 / 3 * camera.focal_px.x, 2) + 0.3);
  const int reach = static_cast<int>(sigma_px * std::sqrt(2 * std::log(0.99 / 0.5)));
  EXPECT_TRUE(find_point(*renderer, camera, {}, {16 + reach, 16}));
  EXPECT_FALSE(find_point(*renderer, camera, {}, {17 + reach, 16}));
  EXPECT_TRUE(find_point(*renderer, camera, {}, {16, 16 - reach}));
  EXPECT_FALSE(find_point(*renderer, camera, {}, {16, 15 - reach}));
}

TEST(Replicate, copies_every_attribute_on_the_floor_of_each_vertical_axis) {
  GaussianCloud cloud = test::random_cloud(40, 1, 5);
  cloud.antialiased = true;
  const glm::vec3 step = 1.1f * core_box(cloud).size();
  for (int vertical = 0; vertical < 3; ++vertical) {
    glm::dvec3 up(0.1);
    up[vertical] = -1;
    const GaussianCloud grid = replicate(cloud, {2, 3}, up);
    ASSERT_EQ(grid.size(), 240u);
    EXPECT_TRUE(grid.antialiased);
    for (std::size_t copy = 0; copy < 6; ++copy) {
      glm::vec3 offset(0);
      offset[(vertical + 1) % 3] = static_cast<float>(copy % 2) * step[(vertical + 1) % 3];
      offset[(vertical + 2) % 3] = static_cast<float>(copy / 2) * step[(vertical + 2) % 3];
      for (const std::size_t i : {0u, 39u}) {
        const std::size_t at = 40 * copy + i;
        EXPECT_LT(glm::distance(grid.positions[at], cloud.positions[i] + offset), 1e-4f);
        EXPECT_EQ(grid.log_scales[at], cloud.log_scales[i]);
        EXPECT_EQ(grid.rotations[at], cloud.rotations[i]);
        EXPECT_EQ(grid.opacity_logits[at], cloud.opacity_logits[i]);
        EXPECT_EQ(grid.sh[4 * at + 3], cloud.sh[4 * i + 3]);
      }
    }
  }
  EXPECT_EQ(error_of([&] {
              replicate(test::random_cloud(2, 0, 1), {1 << 15, 1 << 15}, {0, 1, 0});
            }),
            "--replicate: 1073741824 copies of 2 Gaussians are more than 2^31");
}

}  // namespace
}  // namespace qs
