// SPDX-License-Identifier: MIT
//
// The viewer's render thread without a window.
#include "app/viewer/render/render_thread.h"

#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/rendering_viewer.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/render/render_context.h"
#include "io/picture/image_file.h"
#include "support/pool.h"

namespace qs {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

using RenderThreadTest = test::RenderingViewer;

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * 4096;
}

TEST_F(RenderThreadTest, reports_the_scene_and_draws_it) {
  EXPECT_EQ(viewer().scene->name, "random");
  EXPECT_FALSE(viewer().loading);
  const auto frame = draw(request_);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->width, 96);
  EXPECT_EQ(frame->rgba.size(), 4u * 96 * 64);
  EXPECT_GT(frame->shown.stats.tile_pairs, 0u);
}

TEST_F(RenderThreadTest, a_heat_map_s_sum_is_the_frame_s_pairs) {
  request_.heatmap = HeatQuantity::pairs;
  const auto frame = draw(request_);
  ASSERT_TRUE(frame && frame->shown.heatmap);
  EXPECT_EQ(frame->shown.heatmap->total, frame->shown.stats.tile_pairs);
}

TEST_F(RenderThreadTest, a_picture_of_depth_brings_its_values_and_their_colours) {
  request_.quantity = Quantity::depth;
  const auto frame = draw(request_);
  ASSERT_TRUE(frame && frame->shown.values);
  const ValueMap& map = *frame->shown.values;
  EXPECT_EQ(map.values.size(), 96u * 64);
  const Image expected = colored(map);
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_EQ(frame->rgba[4 * i + c], to_8bit(expected.values[3 * i + c]));
  }
  EXPECT_FALSE(frame->shown.heatmap);
}

TEST_F(RenderThreadTest, a_split_request_brings_both_frames_and_their_difference) {
  FrameRequest other = request_;
  other.settings.mode = find_culler("dualbox");
  const auto alone = draw(request_), beside = draw(other);
  request_.other = Variant{other.settings.mode, request_.settings.pipeline, Backend::cpu};
  const auto both = draw(request_);
  ASSERT_TRUE(alone && beside && both && both->shown.other && both->shown.other->pairs);
  EXPECT_EQ(both->rgba, alone->rgba);
  EXPECT_EQ(both->other, beside->rgba);
  EXPECT_EQ(both->shown.other->stats.tile_pairs, beside->shown.stats.tile_pairs);
  EXPECT_EQ(both->shown.other->pairs->total,
            static_cast<std::int64_t>(alone->shown.stats.tile_pairs) -
                static_cast<std::int64_t>(beside->shown.stats.tile_pairs));
  EXPECT_GT(both->shown.other->pixels.pixels, 0u);
}

TEST_F(RenderThreadTest, another_scene_is_drawn_beside_from_the_same_camera_in_the_same_mode) {
  const auto alone = draw(request_);
  auto scene = std::make_shared<Scene>();
  scene->path = "other.ply";
  scene->cloud = test::random_cloud(200, 2, 77);
  show_beside_it(scene);
  ASSERT_TRUE(viewer().beside);
  EXPECT_EQ(viewer().beside->gaussians, 200u);
  EXPECT_FALSE(viewer().loading);
  change([](Viewer& viewer) { viewer.settings.mode = find_culler("adr"); });
  const FrameRequest request = full_frame(viewer());
  const auto both = draw(request);
  ASSERT_TRUE(both && both->shown.other && both->shown.other->scene && both->shown.other->pairs);
  EXPECT_EQ(both->shown.other->variant, viewer().variant());

  const auto renderer = make_renderer(Backend::cpu, test::pool(1));
  renderer->upload(scene->cloud, {});
  const Frame& expected = renderer->render(request.camera, request.settings);
  EXPECT_EQ(both->shown.other->stats.tile_pairs, expected.stats.tile_pairs);
  EXPECT_EQ(both->shown.other->pairs->total,
            static_cast<std::int64_t>(both->shown.stats.tile_pairs) -
                static_cast<std::int64_t>(expected.stats.tile_pairs));
  for (std::size_t i = 0; i < expected.color.values.size(); ++i)
    ASSERT_EQ(both->other[i / 3 * 4 + i % 3], to_8bit(expected.color.values[i])) << i;
  for (std::size_t i = 0; i < alone->rgba.size(); ++i)  // lossless modes differ by rounding
    ASSERT_NEAR(both->rgba[i], alone->rgba[i], 1) << i;

  press("Ctrl+Shift+O");
  EXPECT_FALSE(draw(full_frame(viewer()))->shown.other);
  // A request from before the scene was closed still draws something.
  EXPECT_FALSE(draw(request)->shown.other->scene);
}

TEST_F(RenderThreadTest, the_reference_is_beside_a_view_until_the_view_moves_on) {
  request_.other = Variant{kReferenceMode, Pipeline::fast, Backend::cpu};
  EXPECT_FALSE(draw(request_)->shown.other);
  change([&](Viewer& viewer) {
    viewer.panels.split = true;
    viewer.split.other = *request_.other;
    viewer.cursor = {-40, 20};
  });
  press("Shift+0");
  const auto beside = settle();
  ASSERT_TRUE(beside && beside->shown.other);
  EXPECT_EQ(viewer().comparison->view_version, viewer().view_version);
  const PixelBox& region = beside->shown.other->region;  // 256 pixels around 0, 20, cut
  EXPECT_EQ(region.x0, 0);
  EXPECT_EQ(region.x1, 96);
  EXPECT_LE(beside->shown.other->pixels.largest, 1);
  EXPECT_FALSE(beside->shown.other->pairs);
  request_.view_version = viewer().view_version + 1;
  EXPECT_FALSE(draw(request_)->shown.other);
}

TEST_F(RenderThreadTest, a_map_of_missed_contributions_knows_their_alphas) {
  request_.heatmap = HeatQuantity::missed;
  request_.settings.mode = find_culler("dualbox");
  const auto frame = draw(request_);
  ASSERT_TRUE(frame && frame->shown.heatmap && frame->shown.missed);
  EXPECT_GT(frame->shown.missed->largest_alpha, 0.0f);
  EXPECT_EQ(frame->shown.heatmap->total, frame->shown.missed->total);
  request_.settings.mode = find_culler("exact");
  EXPECT_EQ(draw(request_)->shown.heatmap->total, 0u);
}

TEST_F(RenderThreadTest, smaller_frames_say_so) {
  request_.divisor = 3;
  const auto frame = draw(request_);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->width, 32);
  EXPECT_EQ(frame->shown.divisor, 3);
  EXPECT_EQ(frame->shown.camera.width, 96);
}

TEST_F(RenderThreadTest, smaller_frames_are_as_bright_as_the_full_one) {
  // Dots smaller than a pixel, which the low-pass dilation enlarges.
  Scene dots;
  dots.cloud = test::random_cloud(20000, 0, 3);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-1, 1);
  for (std::size_t i = 0; i < dots.cloud.size(); ++i) {
    dots.cloud.positions[i] = {2.2f * place(random), 1.2f * place(random), 4.0f};
    dots.cloud.log_scales[i] = glm::vec3(std::log(0.0016f));
    dots.cloud.opacity_logits[i] = 1.0f;
    dots.cloud.sh[i] = glm::vec3(1.0f);
  }
  show(std::move(dots), {});
  apply(call(action::resize, 640, 360));
  apply(call(action::set_camera, test::front_camera(640, 360)));
  const auto brightness = [&](int divisor) {
    request_ = full_frame(viewer());
    request_.divisor = divisor;
    const auto frame = draw(request_);
    double sum = 0;
    for (std::size_t i = 0; frame && i < frame->rgba.size(); ++i)
      if (i % 4 != 3) sum += frame->rgba[i];
    return frame ? sum / (frame->width * frame->height) : 0;
  };
  const double full = brightness(1);
  EXPECT_GT(full, 10);
  for (const int divisor : {2, 3})
    EXPECT_NEAR(brightness(divisor) / full, 1, 0.01) << "divisor " << divisor;
}

TEST_F(RenderThreadTest, the_newest_request_is_the_one_that_is_drawn) {
  for (int version = 0; version < 20; ++version) {
    request_.version = version;
    thread_.request(request_);
  }
  const auto frame = settle();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->shown.version, 19);
}

TEST_F(RenderThreadTest, a_thousand_switches_leave_image_and_memory_alone) {
  const auto first = draw(request_);
  std::mt19937 random(7);
  std::size_t before = 0;
  for (int i = 0; i < 1000; ++i) {
    FrameRequest request = request_;
    request.settings.mode = 1 + static_cast<int>(random() % culler_count());
    request.settings.sh_degree = static_cast<int>(random() % 4);
    request.settings.splat_scale = 0.5f + 0.001f * static_cast<float>(random() % 1000);
    request.settings.background = glm::vec3(static_cast<float>(random() % 2));
    request.settings.antialiased = random() % 2 == 0;
    if (random() % 4 == 0) request.heatmap = static_cast<HeatQuantity>(random() % kHeatQuantities);
    thread_.request(request);
    if (i % 10 == 0) settle();
    if (i == 300) before = resident_bytes();
  }
  settle();
  EXPECT_LT(resident_bytes(), before + (std::size_t{16} << 20));
  EXPECT_EQ(draw(request_)->rgba, first->rgba);
}

TEST_F(RenderThreadTest, switching_back_to_a_mode_shows_its_picture_again_without_drawing) {
  const FrameRequest first = full_frame(viewer());
  const auto a = draw(first);
  apply(call(action::set_mode, find_culler("3dgs")));
  const FrameRequest second = full_frame(viewer());
  const auto b = draw(second);
  ASSERT_NE(a->shown.stats.tile_pairs, b->shown.stats.tile_pairs);
  apply(call(action::peek_previous_mode, true));
  const auto again = draw(full_frame(viewer()));
  EXPECT_EQ(again->rgba, a->rgba);
  EXPECT_EQ(again->shown.version, viewer().version);
  EXPECT_EQ(again->shown.stats.frame_ms, a->shown.stats.frame_ms) << "drawn again";
  apply(call(action::peek_previous_mode, false));
  EXPECT_EQ(draw(full_frame(viewer()))->shown.stats.frame_ms, b->shown.stats.frame_ms);
  // The same mode is drawn again: a window that draws without pause measures.
  bool drawn_again = false;
  for (int i = 0; i < 20 && !drawn_again; ++i)
    drawn_again = draw(full_frame(viewer()))->shown.stats.frame_ms != b->shown.stats.frame_ms;
  EXPECT_TRUE(drawn_again);
  // Another picture: the kept frames are of no use.
  RenderSettings settings = viewer().settings;
  settings.background = glm::vec3(1);
  apply(call(action::change_settings, settings));
  draw(full_frame(viewer()));
  apply(call(action::peek_previous_mode, true));
  EXPECT_NE(draw(full_frame(viewer()))->rgba, a->rgba);
}

TEST_F(RenderThreadTest, a_frame_that_shall_count_is_drawn) {
  draw(full_frame(viewer()));
  apply(call(action::set_mode, find_culler("3dgs")));
  draw(full_frame(viewer()));
  apply(call(action::peek_previous_mode, true));
  FrameRequest request = full_frame(viewer());
  request.counted = CountedView{request.camera, request.settings};
  EXPECT_FALSE(draw(request)->shown.mode_pairs.empty());
}

TEST_F(RenderThreadTest, every_other_mode_is_paired_before_the_numbers_of_all_modes) {
  thread_.request(NumbersRequest{request_.camera, request_.settings, viewer().view_version});
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  std::set<CullMode> paired;
  while (viewer().numbers.rows.empty() && std::chrono::steady_clock::now() < deadline) {
    Actions reports;
    thread_.take_reports(reports);
    for (const Action& report : reports) {
      const bool measured = !viewer().numbers.rows.empty();
      apply(report);
      for (const PairedFrame& pair : viewer().live.pairs) {
        if (paired.insert(pair.variant.mode).second) {
          EXPECT_FALSE(measured);
        }
      }
    }
  }
  EXPECT_EQ(paired.size(), static_cast<std::size_t>(culler_count() - 1));
  EXPECT_EQ(paired.count(request_.settings.mode), 0u);
  for (const PairedFrame& pair : viewer().live.pairs) {
    EXPECT_EQ(pair.shown, request_.settings.mode);
    EXPECT_EQ(pair.size, glm::ivec2(request_.camera.width, request_.camera.height));
    EXPECT_GT(pair.speed, 0);
  }
}

TEST_F(RenderThreadTest, other_modes_are_drawn_beside_the_pictures_of_a_moving_camera) {
  FrameRequest request = full_frame(viewer());
  request.moving = request.pairs = true;
  request.divisor = 2;
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  const auto modes = [&] {
    std::map<CullMode, int> count;
    for (const PairedFrame& pair : viewer().live.pairs) ++count[pair.variant.mode];
    return count;
  };
  std::size_t pairs = 0;
  while (modes().size() < static_cast<std::size_t>(culler_count() - 1) &&
         std::chrono::steady_clock::now() < deadline) {
    draw(request);
    const std::size_t after = viewer().live.pairs.size();
    EXPECT_LE(after, pairs + 1) << "at most one behind a picture";
    pairs = after;
  }
  EXPECT_EQ(pairs, static_cast<std::size_t>(culler_count() - 1)) << "in turns";
  EXPECT_EQ(modes().count(request.settings.mode), 0u);
  for (const PairedFrame& pair : viewer().live.pairs)
    EXPECT_EQ(pair.size, glm::ivec2(request.camera.width, request.camera.height) / 2);
}

TEST_F(RenderThreadTest, numbers_of_all_modes_arrive_when_nothing_else_is_to_do) {
  thread_.request(NumbersRequest{request_.camera, request_.settings, 42});
  settle();
  EXPECT_EQ(viewer().numbers.version, 42);
  EXPECT_EQ(viewer().numbers.rows.size(), static_cast<std::size_t>(culler_count()));
  EXPECT_FALSE(thread_.measuring());
}

TEST_F(RenderThreadTest, more_numbers_add_frames_to_those_of_the_view) {
  NumbersRequest request{request_.camera, request_.settings, 42};
  thread_.request(request);
  settle();
  ASSERT_FALSE(viewer().numbers.rows.empty());
  const BenchRow first = viewer().numbers.rows.front();
  EXPECT_EQ(first.round_ms.size(), 5u);
  EXPECT_TRUE(first.false_positives);
  request.more = true;
  thread_.request(request);
  settle();
  ASSERT_EQ(viewer().numbers.rows.size(), static_cast<std::size_t>(culler_count()));
  for (const BenchRow& row : viewer().numbers.rows) EXPECT_EQ(row.round_ms.size(), 15u);
  EXPECT_EQ(viewer().numbers.rows.front().false_positives, first.false_positives);
}

TEST_F(RenderThreadTest, screenshots_are_never_written_over_and_equal_a_render) {
  for (int i = 0; i < 2; ++i) press("Ctrl+F12");
  settle();
  const auto path = scenes_ / "screenshots/random_scene_view_quadbox_96x64_0001.png";
  ASSERT_TRUE(std::filesystem::exists(path)) << viewer().toasts.back().text;
  EXPECT_TRUE(
      std::filesystem::exists(scenes_ / "screenshots/random_scene_view_quadbox_96x64_0002.png"));
  const Image saved = read_image(path);
  const auto frame = draw(request_);
  for (std::size_t i = 0; i < saved.values.size(); ++i)
    ASSERT_EQ(to_8bit(saved.values[i]), frame->rgba[i / 3 * 4 + i % 3]);
}

TEST_F(RenderThreadTest, a_recorded_zoom_can_be_stopped_and_saves_nothing) {
  press("Shift+Z");
  while (!viewer().zoom.running && thread_.busy()) {
    take_reports();
    std::this_thread::sleep_for(1ms);
  }
  press("Shift+Z");  // stops it, unless it is over by now
  settle();
  EXPECT_FALSE(viewer().zoom.running);
  const ZoomRecord* record = shown_zoom(viewer().zoom);
  EXPECT_EQ(record == nullptr || record->folder.empty(),
            !std::filesystem::exists(scenes_ / "zoom"));
}

TEST_F(RenderThreadTest, frames_that_met_a_drawing_of_the_window_are_measured_again) {
  int measured = 0, voided = 0;
  thread_.note_drawing();  // the window is being drawn
  thread_.run([&](RenderContext& context) {
    const int result = undisturbed(context, [&](const Progress& progress) {
      ++measured;
      try {
        progress.update(0);
        if (measured == 1) thread_.note_drawing();  // among the frames
        progress.update(0.5f);
        progress.update(0.6f);
      } catch (const Cancelled&) {
        ++voided;
        thread_.note_rest(true);
        throw;
      }
      if (measured == 2) {  // after the last frame
        thread_.note_drawing();
        thread_.note_rest(true);
      }
      return measured;
    });
    EXPECT_EQ(result, 3);
  });
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(measured, 0) << "it waits until the window rests";
  thread_.note_rest(true);
  settle();
  EXPECT_EQ(measured, 3);
  EXPECT_EQ(voided, 1);
}

TEST_F(RenderThreadTest, a_job_that_waits_for_the_window_can_be_stopped) {
  thread_.note_drawing();
  std::atomic<bool> began = false, ended = false;
  thread_.run([&](RenderContext& context) {
    const AtEnd note{[&] { ended = true; }};
    began = true;
    undisturbed(context, [](const Progress&) { return 0; });
  });
  while (!began) std::this_thread::sleep_for(1ms);
  thread_.stop_job();
  settle();
  EXPECT_TRUE(ended);
}

TEST_F(RenderThreadTest, a_click_inspects_its_pixel_and_another_gaussian_can_be_picked) {
  press("B");
  apply(call(action::inspect_pixel, glm::dvec2(48.9, 32.9)));
  settle();
  ASSERT_TRUE(viewer().inspected) << viewer().toasts.back().text;
  const Inspection first = viewer().inspected->inspection;
  EXPECT_EQ(first.pixel.pixel, glm::ivec2(48, 32));
  ASSERT_TRUE(first.gaussian);
  EXPECT_EQ(viewer().inspected->grid.columns, 6);  // 96 pixels
  ASSERT_GT(first.pixel.contributions.size(), 1u);
  for (const Contribution& row : first.pixel.contributions) {
    apply(call(action::inspect_gaussian, row.gaussian));
    settle();
    EXPECT_EQ(viewer().inspected->inspection.gaussian->gaussian, row.gaussian);
    EXPECT_EQ(viewer().inspected->inspection.pixel.pixel, first.pixel.pixel);
  }
}

TEST_F(RenderThreadTest, a_double_click_goes_to_what_is_under_the_cursor_and_turns_around_it) {
  press("B");
  apply(call(action::inspect_pixel, glm::dvec2(48, 32)));
  const Camera before = viewer().camera;
  apply(call(action::pick_pivot, glm::dvec2(48, 32)));
  settle();
  // Half of the light of the pixel is absorbed in front of the pivot.
  const double depth = (before.view_from_world * glm::dvec4(viewer().pivot, 1)).z;
  bool found = false;
  for (const Contribution& row : viewer().inspected->inspection.pixel.contributions)
    found = found || std::abs(static_cast<double>(row.depth) - depth) < 1e-4;
  EXPECT_TRUE(found);
  const glm::dvec3 seen = viewer().camera.view_from_world * glm::dvec4(viewer().pivot, 1);
  EXPECT_NEAR(seen.x, 0, 1e-9) << "in the middle of the picture";
  EXPECT_LT(seen.z, depth) << "and nearer";
  apply(call(action::pick_pivot, glm::dvec2(-1, -1)));
  settle();
  EXPECT_EQ(viewer().toasts.back().text, "nothing is under the cursor");
}

TEST_F(RenderThreadTest, errors_become_sentences_and_the_thread_lives_on) {
  thread_.run([](RenderContext&) { throw Error(ErrorKind::input, "scene.ply: is broken"); });
  settle();
  EXPECT_EQ(viewer().toasts.back().text, "scene.ply: is broken");
  EXPECT_TRUE(viewer().toasts.back().error);
  EXPECT_TRUE(draw(request_));
}

TEST_F(RenderThreadTest, a_scene_that_does_not_fit_leaves_the_old_one) {
  Scene other;
  ViewedScene facts;
  other.path = facts.path = "/data/other.ply";
  show(std::move(other), facts, Backend::cuda);
  if (viewer().backend == Backend::cuda) GTEST_SKIP() << "a GPU is here";
  EXPECT_EQ(viewer().scene->name, "random");
  EXPECT_TRUE(viewer().toasts.back().error);
  EXPECT_TRUE(draw(request_));
}

}  // namespace
}  // namespace qs
