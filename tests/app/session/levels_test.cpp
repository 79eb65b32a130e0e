// SPDX-License-Identifier: MIT
//
// Sessions that draw a tree of levels of detail by the cut of each view.
#include "app/session/levels.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <fstream>
#include <mutex>
#include <numeric>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/inspect/heatmap_frame.h"
#include "app/session/alterations.h"
#include "app/session/page_edits.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/camera/lens_views.h"
#include "io/scene/writer.h"
#include "learn/lod/build.h"
#include "raster/scene/image_metrics.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;

class LevelsTest : public testing::Test {
 protected:
  LevelsTest() {
    test::write_scene(test::random_cloud(4000, 2, 3), folder_ / "scene.ply");
    frame_.scene = built(false);
    frame_.backend = Backend::cpu;
    camera_ = look_at({0, 0, -6}, {0, 0, 0}, {0, -1, 0}, 0.9, 160, 120);
  }

  std::filesystem::path built(bool original) {
    LodBuild build;
    build.inputs = {folder_ / "scene.ply"};
    build.output = folder_ / (original ? "original.rad" : "scene.rad");
    build.original = original;
    build.warn = [](const std::string&) {};
    build_lod(build, test::pool());
    return build.output;
  }

  Image picture(Session& session, const Camera& camera) {
    return session.renderer->render(camera, session.settings).color;
  }

  // Draws until the cut of the window is exact and was drawn.
  const Frame* settled(Renderer& renderer, std::atomic<int>& reports) {
    const Frame* frame = &renderer.render(camera_);
    for (int quiet = 0, seen = 0; quiet < 10; ++quiet) {
      std::this_thread::sleep_for(std::chrono::milliseconds(60));
      if (reports != seen) quiet = 0;
      seen = reports;
      frame = &renderer.render(camera_);
    }
    return frame;
  }

  TemporaryFolder folder_;
  FrameOptions frame_;
  Camera camera_;
};

TEST_F(LevelsTest, error_0_draws_the_bits_of_the_whole_file_in_every_mode) {
  Session whole = open_session(frame_);
  frame_.levels.error = 0;
  Session levels = open_session(frame_);
  for (const CullMode mode : all_modes())
    for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
      whole.settings.mode = levels.settings.mode = mode;
      whole.settings.pipeline = levels.settings.pipeline = pipeline;
      const Image expected = picture(whole, camera_);
      EXPECT_EQ(picture(levels, camera_).values, expected.values);
    }
  const Outputs pairs{.color = false, .pairs = true};
  const auto counted = [&](Session& s) {
    return s.renderer->render(camera_, s.settings, pairs).stats.tile_pairs;
  };
  EXPECT_EQ(counted(levels), counted(whole));
}

TEST_F(LevelsTest, a_scene_far_away_is_drawn_as_exactly_as_one_near_0) {
  GaussianCloud cloud = test::random_cloud(4000, 2, 3);
  cloud.origin = {500'000, 4'650'000, 200};
  test::write_scene(cloud, folder_ / "scene.ply");
  const GaussianCloud read = read_scene(folder_ / "scene.ply", test::pool()).cloud;
  frame_.levels.budget = 500;
  const auto draw = [&] {
    built(false);
    Session session = open_session(frame_);
    Camera camera = camera_;
    camera.origin = read.origin;
    return std::pair(session.scene->cloud.origin,
                     picture(session, camera.placed(session.scene->cloud.origin)));
  };
  const auto [far, far_picture] = draw();
  cloud = read;
  cloud.origin = {};
  test::write_scene(cloud, folder_ / "scene.ply");
  const auto [near, near_picture] = draw();
  EXPECT_EQ(far, read.origin);
  EXPECT_EQ(near, glm::dvec3(0));
  EXPECT_EQ(far_picture.values, near_picture.values);
}

class EditedLevels : public LevelsTest {
 protected:
  void write(const std::string& steps) {
    frame_.edits.file = folder_ / "a.edits.json";
    std::ofstream(*frame_.edits.file) << R"({"version": 1, "steps": [)" << steps << "]}";
  }
  static std::string camera() {
    return R"("camera": )" +
           json_line(camera_json(look_at({1.5, 0, -6}, {0, 0, 4}, {0, -1, 0}, 0.7, 160, 120)));
  }
};

TEST_F(EditedLevels, leaves_are_the_bits_of_the_edited_file) {
  const std::string cases[] = {
      R"({"step": "crop", "box": [[-1, -0.3, -9], [0.25, 0.4, 9]]})",
      R"({"step": "select", "tool": "sphere", "point": [0.5, 0, 3], "radius": 1}, {"step": "keep"})",
      R"({"step": "select", "tool": "distance", "point": [0.1, 0, 0], "normal": [1, 2, 0], "low": 0}, )"
      R"({"step": "hide"})",
      R"({"step": "select", "tool": "opacity", "high": 0.4}, {"step": "remove"})",
      R"({"step": "select", "tool": "brush", "kind": "through", "radius": 20, "pixels": [[40, 40], [90, 70]], )" +
          camera() + R"(}, {"step": "remove"})",
      R"({"step": "select", "tool": "lasso", "kind": "through", "pixels": [[20, 10], [140, 20], [80, 110]], )" +
          camera() + R"(}, {"step": "keep"})"};
  for (const std::string& steps : cases) {
    write(steps);
    frame_.levels = {};
    Session whole = open_session(frame_);
    const Image expected = picture(whole, camera_);
    frame_.levels.error = 0;
    Session levels = open_session(frame_);
    EXPECT_EQ(picture(levels, camera_).values, expected.values) << steps;
    EXPECT_THAT(alterations_of(levels).text, HasSubstr("edited: 1 step, each page, crc32:"));
    // Borders are exact long before all leaves are drawn.
    frame_.levels = {};
    frame_.levels.budget = 3000;
    Session some = open_session(frame_);
    EXPECT_GT(psnr(picture(some, camera_), expected, test::pool()), 30) << steps;
  }
}

TEST_F(EditedLevels, lists_are_of_the_numbers_of_leaves) {
  frame_.scene = built(true);
  const Scene source = load_scene(folder_ / "scene.ply", test::pool());
  std::string members;
  for (const GaussianRun& run : gaussians_at_distance(source.cloud, glm::dvec3(0),
                                                      glm::dvec3(1, 2, 0), {0, 100}, test::pool())
                                    .runs())
    members += fmt::format("{}{}, {}", members.empty() ? "" : ", ", run.first, run.count);
  for (const std::string last :
       {R"("remove"})", R"("keep"})",
        R"("keep"}, {"step": "crop", "box": [[-1, -0.3, -9], [0.25, 0.4, 9]]})"}) {
    write(R"({"step": "select", "tool": "list", "members": [)" + members + R"(]}, {"step": )" +
          last);
    frame_.levels = {};
    Session whole = open_session(frame_);
    const Image expected = picture(whole, camera_);
    frame_.levels.error = 0;
    Session levels = open_session(frame_);
    EXPECT_EQ(picture(levels, camera_).values, expected.values) << last;
    frame_.levels = {};
    frame_.levels.budget = 3000;
    Session some = open_session(frame_);
    EXPECT_GT(psnr(picture(some, camera_), expected, test::pool()), 30) << last;
  }
}

TEST_F(EditedLevels, a_window_draws_the_edits_of_its_pages_and_their_selection) {
  write(R"({"step": "crop", "box": [[-1, -0.3, -9], [0.25, 0.4, 9]]})");
  Session whole = open_session(frame_);
  const Image edited = picture(whole, camera_);
  frame_.edits = {};
  Session unedited = open_session(frame_);
  const Image plain = picture(unedited, camera_);
  frame_.levels.error = 0;
  const Scene tree = load_scene(frame_.scene, test::pool(), -1, "", StreamedTrees::all);
  std::atomic<int> reports = 0;
  std::atomic<std::size_t> selected = 0;
  const auto window = with_levels(make_renderer(Backend::cpu, test::pool()), frame_.levels,
                                  test::pool(), [&](const LevelFacts& facts) {
                                    selected = facts.selected;
                                    ++reports;
                                  });
  expect_stream(*window, tree.stream);
  window->upload(std::make_shared<const GaussianCloud>(tree.cloud), {});
  const auto edit = [&](const std::vector<EditStep>& steps) {
    tree.stream->edit_pages(steps.empty() ? nullptr : page_editor(steps, "edit", tree),
                            test::pool());
    return settled(*window, reports)->color.values;
  };
  EXPECT_EQ(edit({}), plain.values);
  EXPECT_EQ(edit(read_edits(folder_ / "a.edits.json", tree.cloud.origin).steps), edited.values);
  EXPECT_EQ(edit({}), plain.values);
  const SelectStep sphere{.tool = SelectTool::sphere, .radius = 1, .point = {0.5, 0, 3}};
  EXPECT_EQ(edit({{.select = sphere}}), plain.values);
  const GaussianSet expected = gaussians_at_distance(unedited.scene->cloud, sphere.point, {},
                                                     {0, sphere.radius}, test::pool());
  EXPECT_EQ(selected, expected.count());
  Outputs outputs;
  outputs.share = std::make_shared<const GaussianSet>(expected);
  const std::vector<float> shares =
      unedited.renderer->render(camera_, unedited.settings, outputs).share;
  outputs.share = std::make_shared<const GaussianSet>();
  EXPECT_EQ(window->render(camera_, unedited.settings, outputs).share, shares);
}

TEST_F(LevelsTest, a_drawn_view_knows_the_numbers_of_its_leaves) {
  const Scene source = load_scene(folder_ / "scene.ply", test::pool());
  frame_.scene = built(true);
  frame_.levels.budget = 3000;
  const Session session = open_session(frame_);
  const DrawnView drawn = draw_view(session, camera_, {.color = false, .trace = true}, {});
  ASSERT_EQ(drawn.numbers.size(), drawn.cloud->size());
  std::size_t leaves = 0;
  for (std::size_t i = 0; i < drawn.numbers.size(); ++i) {
    if (drawn.numbers[i] == kNoNumber) continue;
    ++leaves;
    EXPECT_EQ(drawn.cloud->positions[i], source.cloud.positions[drawn.numbers[i]]);
  }
  EXPECT_GT(leaves, 1000u);
  EXPECT_LT(leaves, drawn.numbers.size());
}

// A crop leaves a part of a far larger scene: its border is exact with a budget that is far too
// small for the whole scene.
TEST_F(EditedLevels, the_budget_goes_to_the_rest_and_its_border) {
  write(R"({"step": "crop", "box": [[0.2, 0.2, -9], [0.5, 0.5, 9]]})");
  Session whole = open_session(frame_);
  const auto left = whole.scene->cloud.size();
  ASSERT_LT(left, 500u);
  frame_.levels.budget = 1500;
  Session levels = open_session(frame_);
  EXPECT_EQ(picture(levels, camera_).values, picture(whole, camera_).values);
}

TEST_F(EditedLevels, steps_that_need_the_whole_scene_are_refused) {
  frame_.levels.budget = 100;
  for (const std::string& step :
       {std::string(R"({"step": "floaters"})"),
        R"({"step": "select", "tool": "rectangle", "pixels": [[1, 1], [9, 9]], )" + camera() + "}",
        std::string(R"({"step": "select", "tool": "list", "members": [0, 5]})"),
        std::string(R"({"step": "select", "tool": "grow"})")}) {
    write(R"({"step": "show"}, )" + step);
    EXPECT_THAT(test::error_of([&] { open_session(frame_); }, ErrorKind::usage),
                HasSubstr("a.edits.json: step 2 needs the whole scene"));
  }
}

TEST_F(LevelsTest, error_0_draws_the_bits_of_the_source_if_the_file_keeps_them) {
  GaussianCloud cloud = test::random_cloud(3000, 2, 3);  // many have the same depth
  for (glm::vec3& position : cloud.positions) position.z = std::floor(position.z);
  test::write_scene(cloud, folder_ / "ties.ply");
  LodBuild build;
  build.inputs = {folder_ / "ties.ply"};
  build.output = folder_ / "ties.rad";
  build.memory = 2'000'000;  // several buckets
  build.original = true;
  build.warn = [](const std::string&) {};
  build_lod(build, test::pool());
  frame_.scene = build.inputs[0];
  Session source = open_session(frame_);
  frame_.scene = build.output;
  Session whole = open_session(frame_);
  frame_.levels.error = 0;
  Session levels = open_session(frame_);
  const Scene scene = load_scene(frame_.scene, test::pool(), -1, "", StreamedTrees::all);
  std::atomic<int> reports = 0;
  const auto window = with_levels(make_renderer(Backend::cpu, test::pool()), frame_.levels,
                                  test::pool(), [&](const LevelFacts&) { ++reports; });
  expect_stream(*window, scene.stream);
  window->upload(scene.cloud, {});
  for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
    source.settings.pipeline = whole.settings.pipeline = levels.settings.pipeline = pipeline;
    const Image expected = picture(source, camera_);
    EXPECT_EQ(picture(whole, camera_).values, expected.values);
    EXPECT_EQ(picture(levels, camera_).values, expected.values);
    if (pipeline != RenderSettings{}.pipeline) continue;
    EXPECT_EQ(settled(*window, reports)->color.values, expected.values);
  }
}

TEST_F(LevelsTest, every_view_has_the_cut_of_its_budget) {
  Session whole = open_session(frame_);
  const Image expected = picture(whole, camera_);
  double before = 0;
  for (const int budget : {1, 100, 1000, 2500}) {
    frame_.levels.budget = budget;
    Session session = open_session(frame_);
    const double quality = psnr(picture(session, camera_), expected, test::pool());
    EXPECT_GE(quality, before) << budget;
    before = quality;
    EXPECT_THAT(alterations_of(session).text, HasSubstr("levels of detail"));
    for (const double distance : {-6.0, -2.0, -0.1, -40.0}) {  // also inside of the scene
      const Camera moved = look_at({0.3, 0, distance}, {0, 0, 1}, {0, -1, 0}, 0.9, 160, 120);
      const auto drawn = session.renderer->render(moved, session.settings).stats.gaussians;
      EXPECT_LE(drawn, static_cast<unsigned>(budget));
      EXPECT_GE(drawn, static_cast<unsigned>(budget) * 9 / 10);
    }
  }
  EXPECT_GT(before, 30);
}

TEST_F(LevelsTest, a_cut_does_not_depend_on_the_views_before) {
  frame_.levels.budget = 700;
  Session fresh = open_session(frame_), used = open_session(frame_);
  for (const double z : {-1.0, -30.0, -3.0})
    picture(used, look_at({0, 0, z}, {0, 0, 1}, {0, -1, 0}, 0.9, 80, 60));
  EXPECT_EQ(picture(used, camera_).values, picture(fresh, camera_).values);
}

// A wall hides the left half of the scene, which then gets fewer nodes than the right half.
TEST_F(LevelsTest, nodes_behind_a_wall_leave_the_budget_to_others) {
  constexpr std::size_t kSide = 40;
  const auto grid = [](float left, float step, float z, float log_scale) {
    GaussianCloud cloud = test::random_cloud(kSide * kSide, 0, 5);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const auto column = static_cast<float>(i % kSide), row = static_cast<float>(i / kSide);
      cloud.positions[i] = {left + step * column, step * (row - 0.5f * kSide), z};
      cloud.log_scales[i] = glm::vec3(log_scale);
      cloud.opacity_logits[i] = 4;
    }
    return cloud;
  };
  const GaussianCloud open = grid(-2, 0.1f, 1, -3.5f);
  GaussianCloud hidden = open, wall = grid(-4, 0.1f, -2, -2.3f);
  std::ranges::fill(wall.sh, glm::vec3(0));
  test::append(hidden, wall);
  const auto left_share = [&](const GaussianCloud& cloud) {
    test::write_scene(cloud, folder_ / "scene.ply");
    frame_.scene = built(false);
    frame_.levels.budget = 1200;
    const DrawnView drawn = draw_view(open_session(frame_), camera_, {}, {});
    double left = 0, right = 0;
    for (const glm::vec3& at : drawn.cloud->positions)
      if (at.z > 0) (at.x < 0 ? left : right) += 1;
    return left / (left + right);
  };
  EXPECT_NEAR(left_share(open), 0.5, 0.1);
  EXPECT_LT(left_share(hidden), 0.2);
}

TEST_F(LevelsTest, a_lens_draws_one_cut_for_all_its_faces) {
  LensView vr = panorama_view(180), level = fisheye_view(150);
  vr.eye_distance = 0.2;
  level.up = {0, -1, 0};
  Session whole = open_session(frame_);
  frame_.levels.error = 0;
  Session leaves = open_session(frame_);
  frame_.levels.error = 0.1;
  Session cut = open_session(frame_);
  const Camera inside = look_at({0, 0.3, 3}, {1, 0, 4}, {0, -1, 0}, 0.9, 160, 160);
  Camera behind = inside;  // looks the other way
  for (int column = 0; column < 4; ++column)
    for (const int row : {0, 2}) behind.view_from_world[column][row] *= -1;
  for (const LensView& lens :
       {panorama_view(360), vr, fisheye_view(180), level, parallel_view(5)}) {
    std::vector<double> drawn;
    for (const Camera& camera : {inside, behind}) {
      SCOPED_TRACE(lens.text);
      for (Session* session : {&whole, &leaves, &cut})
        session->settings.lens = std::make_shared<const LensView>(lens);
      const Image expected = picture(whole, camera);
      EXPECT_EQ(picture(leaves, camera).values, expected.values);
      const Frame& frame = cut.renderer->render(camera, cut.settings);
      drawn.push_back(frame.stats.gaussians);
      EXPECT_LT(drawn.back(), 3500);
      EXPECT_GT(psnr(frame.color, expected, test::pool()), 32);
    }
    // All directions count alike.
    if (lens.text == panorama_view(360).text) {
      EXPECT_NEAR(drawn[0], drawn[1], 5);
    }
  }
}

TEST_F(LevelsTest, both_limits_hold) {
  frame_.levels.error = 1e-3;
  Session by_error = open_session(frame_);
  const auto drawn = by_error.renderer->render(camera_).stats.gaussians;
  EXPECT_LT(drawn, 4000u);
  frame_.levels.budget = static_cast<int>(drawn) + 100;
  Session loose = open_session(frame_);
  EXPECT_EQ(loose.renderer->render(camera_).stats.gaussians, drawn);
  frame_.levels.budget = 50;
  Session tight = open_session(frame_);
  EXPECT_LE(tight.renderer->render(camera_).stats.gaussians, 50u);
}

TEST_F(LevelsTest, a_window_ends_at_the_cut_of_its_view) {
  const Scene scene = load_scene(frame_.scene, test::pool(), -1, "", StreamedTrees::all);
  LevelOptions options;
  options.budget = 800;
  std::atomic<int> reports = 0;
  std::mutex mutex;
  LevelFacts last;
  const auto renderer = with_levels(make_renderer(Backend::cpu, test::pool()), options,
                                    test::pool(), [&](const LevelFacts& facts) {
                                      const std::lock_guard lock(mutex);
                                      last = facts;
                                      ++reports;
                                    });
  expect_stream(*renderer, scene.stream);
  renderer->upload(scene.cloud, {});
  EXPECT_EQ(renderer->render(camera_).stats.gaussians, scene.cloud.size());  // at once, coarse
  const Frame* frame = settled(*renderer, reports);
  EXPECT_LE(frame->stats.gaussians, 800u);
  EXPECT_GE(frame->stats.gaussians, 700u);
  EXPECT_EQ(last.drawn, frame->stats.gaussians);
  EXPECT_EQ(last.missing, 0u);
  EXPECT_THAT(last.text(), HasSubstr(" nodes, limit "));
  const int before = reports;
  renderer->render(camera_.resized(80, 60));  // a reduced frame has the same cut
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  EXPECT_EQ(reports, before);
  EXPECT_EQ(test::error_of([&] { renderer->set_drawn(GaussianSet(7310)); }, ErrorKind::device),
            "the renderer cannot leave out Gaussians");
  // A scene without levels takes its place, and its Gaussians can be left out.
  const auto cloud = std::make_shared<GaussianCloud>(test::random_cloud(50, 0, 1));
  renderer->upload(cloud, {});
  EXPECT_EQ(renderer->render(camera_).stats.gaussians, 50u);
  const std::vector<float> whole = renderer->render(camera_).color.values;
  renderer->set_drawn(GaussianSet(50));
  EXPECT_EQ(renderer->render(camera_).stats.gaussians, 0u);
  renderer->set_drawn(GaussianSet());
  EXPECT_EQ(renderer->render(camera_).color.values, whole);
  std::vector<std::uint32_t> all(50);
  std::iota(all.begin(), all.end(), 0u);
  for (float& logit : cloud->opacity_logits) logit = -20;
  renderer->update(all);
  EXPECT_NE(renderer->render(camera_).color.values, whole);
}

TEST_F(LevelsTest, the_picture_of_a_resting_window_does_not_depend_on_the_flight) {
  const Scene scene = load_scene(frame_.scene, test::pool(), -1, "", StreamedTrees::all);
  for (const int budget : {700, 1'000'000}) {
    frame_.levels.budget = budget;
    std::atomic<int> reports = 0;
    const auto open = [&] {
      auto window = with_levels(make_renderer(Backend::cpu, test::pool()), frame_.levels,
                                test::pool(), [&](const LevelFacts&) { ++reports; });
      expect_stream(*window, scene.stream);
      window->upload(scene.cloud, {});
      return window;
    };
    const auto flown = open(), fresh = open();
    settled(*flown, reports);
    for (int step = 0; step < 40; ++step) {
      const double angle = 0.05 * step;
      const Camera moving = look_at({6 * std::sin(angle), 0.02 * step, -6 * std::cos(angle)},
                                    {0, 0, 0}, {0, -1, 0}, 0.9, 160, 120);
      const Frame& frame = flown->render(step % 3 == 0 ? moving.resized(80, 60) : moving);
      EXPECT_LE(frame.stats.gaussians, static_cast<unsigned>(budget));
      std::this_thread::sleep_for(std::chrono::milliseconds(step % 4));
    }
    settled(*flown, reports);
    settled(*fresh, reports);
    Session command = open_session(frame_);
    RenderSettings settings;
    for (const CullMode mode : all_modes()) {
      settings.mode = command.settings.mode = mode;
      const Image image = flown->render(camera_, settings).color;
      EXPECT_EQ(image.values, fresh->render(camera_, settings).color.values) << budget;
      if (budget > 4000) {  // all leaves
        EXPECT_EQ(image.values, picture(command, camera_).values);
      }
    }
  }
}

TEST_F(LevelsTest, films_and_measurements_of_a_window_have_the_cuts_of_a_command) {
  const Scene scene = load_scene(frame_.scene, test::pool(), -1, "", StreamedTrees::all);
  frame_.levels.budget = 900;
  std::atomic<int> reports = 0, new_cuts = 0;
  std::atomic<bool> awaits = false;
  const auto window = with_levels(
      make_renderer(Backend::cpu, test::pool()), frame_.levels, test::pool(),
      [&](const LevelFacts& facts) {
        new_cuts += facts.is_new ? 1 : 0;
        ++reports;
      },
      &awaits);
  expect_stream(*window, scene.stream);
  window->upload(scene.cloud, {});
  const std::vector<float> before = settled(*window, reports)->color.values;
  const int known = new_cuts;
  Session command = open_session(frame_);
  for (int round = 0; round < 3; ++round) {
    awaits = true;
    for (const double z : {-6.0, -1.5, -20.0, -6.0}) {
      const Camera moved = look_at({0.3, 0, z}, {0, 0, 1}, {0, -1, 0}, 0.9, 160, 120);
      EXPECT_EQ(window->render(moved).color.values, picture(command, moved).values) << z;
    }
    EXPECT_EQ(window->render(camera_).color.values, picture(command, camera_).values);
    awaits = false;
    EXPECT_EQ(window->render(camera_).color.values, before);  // at once
    EXPECT_EQ(settled(*window, reports)->color.values, before);
    EXPECT_EQ(new_cuts, known);  // nothing new to draw
  }
}

TEST_F(LevelsTest, the_budget_follows_the_time_of_frames) {
  const Scene scene = load_scene(frame_.scene, test::pool(), -1, "", StreamedTrees::all);
  LevelOptions options;
  options.budget = 4000;
  options.budget_ms = 1e-6;  // never reached
  std::atomic<int> reports = 0;
  const auto renderer = with_levels(make_renderer(Backend::cpu, test::pool()), options,
                                    test::pool(), [&](const LevelFacts&) { ++reports; });
  expect_stream(*renderer, scene.stream);
  renderer->upload(scene.cloud, {});
  for (int i = 0; i < 60; ++i) renderer->render(camera_);
  const Frame* frame = settled(*renderer, reports);
  EXPECT_LE(frame->stats.gaussians, 1000u);  // the least budget
}

double mean_of(const Heatmap& map) {
  return static_cast<double>(map.total) / static_cast<double>(map.values.size());
}

TEST_F(LevelsTest, heat_maps_show_levels_and_estimated_errors) {
  Session whole = open_session(frame_);
  const Image leaves = picture(whole, camera_);
  for (const HeatQuantity quantity : {HeatQuantity::level, HeatQuantity::error}) {
    const auto map_of = [&](Session& session) {
      return render_with_heatmap(*session.renderer, camera_, session.settings, quantity,
                                 *session.pool)
          .heatmap;
    };
    EXPECT_EQ(mean_of(map_of(whole)), 0);
    frame_.levels = {};
    frame_.levels.error = 0;
    Session exact = open_session(frame_);
    EXPECT_EQ(map_of(exact).largest, 0u);
    double before = 1e9;
    frame_.levels = {};
    for (const int budget : {1, 40, 400, 1500, 3000}) {
      frame_.levels.budget = budget;
      Session session = open_session(frame_);
      const Heatmap map = map_of(session);
      ASSERT_EQ(map.values.size(), 160u * 120u);
      EXPECT_EQ(map.quantity, quantity);
      EXPECT_GT(map.largest, 0u) << budget;
      EXPECT_LT(mean_of(map), before) << budget;
      before = mean_of(map);
      if (quantity == HeatQuantity::level) {
        EXPECT_LE(map.largest, 12u) << budget;  // 4000 leaves
      }
    }
  }
  // The mean estimate is near the mean difference of the pictures.
  frame_.levels.budget = 1500;
  Session session = open_session(frame_);
  const HeatmapFrame mapped = render_with_heatmap(*session.renderer, camera_, session.settings,
                                                  HeatQuantity::error, *session.pool);
  double measured = 0, estimated = 0;
  for (std::size_t i = 0; i < leaves.values.size(); ++i)
    measured += std::pow(255 * (static_cast<double>(mapped.frame.color.values[i]) -
                                static_cast<double>(leaves.values[i])),
                         2);
  for (const std::uint32_t value : mapped.heatmap.values) estimated += 3.0 * value * value;
  EXPECT_GT(estimated, 0.2 * measured);
  EXPECT_LT(estimated, 20 * measured);
}

TEST_F(LevelsTest, a_heat_map_leaves_the_picture_as_it_is) {
  frame_.levels.budget = 700;
  Session session = open_session(frame_);
  const Image before = picture(session, camera_);
  for (const HeatQuantity quantity : {HeatQuantity::level, HeatQuantity::error}) {
    const HeatmapFrame mapped =
        render_with_heatmap(*session.renderer, camera_, session.settings, quantity, *session.pool);
    EXPECT_EQ(mapped.frame.color.values, before.values);
  }
  EXPECT_EQ(picture(session, camera_).values, before.values);
  const Heatmap map = render_with_heatmap(*session.renderer, camera_, session.settings,
                                          HeatQuantity::level, *session.pool)
                          .heatmap;
  const Legend legend = make_legend(map, scale_for(map.values), "quadbox");
  EXPECT_THAT(legend.facts, HasSubstr("mode quadbox"));
  EXPECT_THAT(legend.facts, testing::Not(HasSubstr("in all")));  // a sum of levels is no fact
}

TEST_F(LevelsTest, a_window_shows_its_cut_again_after_a_heat_map) {
  const Scene scene = load_scene(frame_.scene, test::pool(), -1, "", StreamedTrees::all);
  LevelOptions options;
  options.budget = 800;
  std::atomic<int> reports = 0;
  const auto renderer = with_levels(make_renderer(Backend::cpu, test::pool()), options,
                                    test::pool(), [&](const LevelFacts&) { ++reports; });
  expect_stream(*renderer, scene.stream);
  renderer->upload(scene.cloud, {});
  const Image before = settled(*renderer, reports)->color;
  for (int round = 0; round < 3; ++round) {
    const HeatmapFrame mapped =
        render_with_heatmap(*renderer, camera_, {}, HeatQuantity::level, test::pool());
    EXPECT_GT(mapped.heatmap.total, 0u);
    EXPECT_GT(psnr(mapped.frame.color, before, test::pool()), 40);
  }
  EXPECT_EQ(settled(*renderer, reports)->color.values, before.values);
}

}  // namespace
}  // namespace qs
