// SPDX-License-Identifier: MIT
//
// The viewer's render thread without a window.
#include "app/viewer/render/render_thread.h"

#include <chrono>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/viewer/render/jobs.h"
#include "io/picture/image_file.h"
#include "io/scene/writer.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

// What the loop on the main thread does with a render thread, without a window.
class RenderThreadTest : public testing::Test {
 protected:
  RenderThreadTest()
      : thread_(
            {1, 0}, [] {}, nullptr) {
    LoadedScene loaded;
    loaded.scene.cloud = test::random_cloud(300, 1, 5);
    loaded.scene.path = scenes_ / "random.ply";
    test::write_scene(loaded.scene.cloud, loaded.scene.path);
    loaded.facts.name = "random";
    loaded.facts.path = loaded.scene.path;
    thread_.run(open_scene(std::move(loaded), Backend::cpu, {}, false));
    settle();
    order_.camera = test::front_camera(96, 64);
  }

  // Until nothing runs; returns the newest frame.
  std::optional<FrameReply> settle() {
    std::optional<FrameReply> newest;
    const auto deadline = std::chrono::steady_clock::now() + 120s;
    while (std::chrono::steady_clock::now() < deadline) {
      thread_.take_reports(reports_);
      if (auto frame = thread_.take_frame()) newest = std::move(frame);
      if (!thread_.busy()) return newest;
      std::this_thread::sleep_for(1ms);
    }
    ADD_FAILURE() << "the render thread does not come to rest";
    return newest;
  }

  std::optional<FrameReply> draw(const FrameOrder& order) {
    thread_.order(order);
    return settle();
  }

  template <class T>
  const T* last_report() const {
    const T* found = nullptr;
    for (const Action& action : reports_) {
      if (const T* here = std::get_if<T>(&action)) found = here;
    }
    return found;
  }

  TemporaryFolder scenes_;
  RenderThread thread_;
  FrameOrder order_;
  Actions reports_;
};

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * 4096;
}

TEST_F(RenderThreadTest, reports_the_scene_and_draws_it) {
  ASSERT_NE(last_report<action::SceneOpened>(), nullptr);
  const auto frame = draw(order_);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->width, 96);
  EXPECT_EQ(frame->rgba.size(), 4u * 96 * 64);
  EXPECT_GT(frame->shown.stats.tile_pairs, 0u);
}

TEST_F(RenderThreadTest, a_heat_map_s_sum_is_the_frame_s_pairs) {
  order_.heatmap = HeatQuantity::pairs;
  const auto frame = draw(order_);
  ASSERT_TRUE(frame && frame->shown.heatmap);
  EXPECT_EQ(frame->shown.heatmap->total, frame->shown.stats.tile_pairs);
}

TEST_F(RenderThreadTest, a_split_order_brings_both_frames_and_their_difference) {
  FrameOrder other = order_;
  other.settings.mode = find_culler("dualbox");
  const auto alone = draw(order_), beside = draw(other);
  order_.other = Variant{other.settings.mode, order_.settings.pipeline, Backend::cpu};
  const auto both = draw(order_);
  ASSERT_TRUE(alone && beside && both && both->shown.other && both->shown.other->pairs);
  EXPECT_EQ(both->rgba, alone->rgba);
  EXPECT_EQ(both->other, beside->rgba);
  EXPECT_EQ(both->shown.other->stats.tile_pairs, beside->shown.stats.tile_pairs);
  EXPECT_EQ(both->shown.other->pairs->total,
            static_cast<std::int64_t>(alone->shown.stats.tile_pairs) -
                static_cast<std::int64_t>(beside->shown.stats.tile_pairs));
  EXPECT_GT(both->shown.other->pixels.pixels, 0u);
}

TEST_F(RenderThreadTest, the_reference_is_beside_a_view_until_the_view_moves_on) {
  order_.other = Variant{kReferenceMode, Pipeline::fast, Backend::cpu};
  EXPECT_FALSE(draw(order_)->shown.other);
  thread_.run(ask_oracle_about(order_, PixelBox{10, 20, 40, 50}));
  const auto beside = settle();
  ASSERT_TRUE(beside && beside->shown.other);
  EXPECT_EQ(beside->shown.other->region.x1, 40);
  EXPECT_LE(beside->shown.other->pixels.largest, 1);
  EXPECT_FALSE(beside->shown.other->pairs);
  ++order_.view_version;
  EXPECT_FALSE(draw(order_)->shown.other);
}

TEST_F(RenderThreadTest, a_map_of_missed_contributions_knows_their_alphas) {
  order_.heatmap = HeatQuantity::missed;
  order_.settings.mode = find_culler("dualbox");
  const auto frame = draw(order_);
  ASSERT_TRUE(frame && frame->shown.heatmap && frame->shown.missed);
  EXPECT_GT(frame->shown.missed->largest_alpha, 0.0f);
  EXPECT_EQ(frame->shown.heatmap->total, frame->shown.missed->total);
  order_.settings.mode = find_culler("exact");
  EXPECT_EQ(draw(order_)->shown.heatmap->total, 0u);
}

TEST_F(RenderThreadTest, smaller_frames_say_so) {
  order_.divisor = 3;
  const auto frame = draw(order_);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->width, 32);
  EXPECT_EQ(frame->shown.divisor, 3);
  EXPECT_EQ(frame->shown.camera.width, 96);
}

TEST_F(RenderThreadTest, the_newest_order_is_the_one_that_is_drawn) {
  for (int version = 0; version < 20; ++version) {
    order_.version = version;
    thread_.order(order_);
  }
  const auto frame = settle();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->shown.version, 19);
}

TEST_F(RenderThreadTest, a_thousand_switches_leave_image_and_memory_alone) {
  const auto first = draw(order_);
  std::mt19937 random(7);
  std::size_t before = 0;
  for (int i = 0; i < 1000; ++i) {
    FrameOrder order = order_;
    order.settings.mode = 1 + static_cast<int>(random() % kCullerCount);
    order.settings.sh_degree = static_cast<int>(random() % 4);
    order.settings.splat_scale = 0.5f + 0.001f * static_cast<float>(random() % 1000);
    order.settings.background = glm::vec3(static_cast<float>(random() % 2));
    order.settings.antialiased = random() % 2 == 0;
    if (random() % 4 == 0) order.heatmap = static_cast<HeatQuantity>(random() % kHeatQuantities);
    thread_.order(order);
    if (i % 50 == 0) thread_.run(switch_backend(Backend::cpu));
    if (i % 10 == 0) settle();
    if (i == 300) before = resident_bytes();
  }
  settle();
  EXPECT_LT(resident_bytes(), before + (std::size_t{16} << 20));
  EXPECT_EQ(draw(order_)->rgba, first->rgba);
}

TEST_F(RenderThreadTest, numbers_of_all_modes_arrive_when_nothing_else_is_to_do) {
  thread_.order(NumbersOrder{order_.camera, order_.settings, 42});
  settle();
  const auto* measured = last_report<action::NumbersMeasured>();
  ASSERT_NE(measured, nullptr);
  EXPECT_EQ(measured->numbers.version, 42);
  EXPECT_EQ(measured->numbers.rows.size(), static_cast<std::size_t>(kCullerCount));
  EXPECT_FALSE(last_report<action::MeasuringChanged>()->running);
}

TEST_F(RenderThreadTest, screenshots_are_never_written_over_and_equal_a_render) {
  const TemporaryFolder folder;
  for (int i = 0; i < 2; ++i) thread_.run(take_screenshot(order_, "camera 3/x", folder.path()));
  settle();
  const auto path = folder / "screenshots/random_camera_3_x_quadbox_96x64_0001.png";
  ASSERT_TRUE(std::filesystem::exists(path));
  EXPECT_TRUE(
      std::filesystem::exists(folder / "screenshots/random_camera_3_x_quadbox_96x64_0002.png"));
  const Image written = read_image(path);
  const auto frame = draw(order_);
  for (std::size_t i = 0; i < written.values.size(); ++i)
    ASSERT_EQ(to_8bit(written.values[i]), frame->rgba[i / 3 * 4 + i % 3]);
}

TEST_F(RenderThreadTest, a_recorded_zoom_can_be_stopped_and_saves_nothing) {
  const TemporaryFolder folder;
  thread_.run(record_zoom_from(order_, {48, 32}, folder.path()));
  while (last_report<action::ZoomStepped>() == nullptr && thread_.busy()) {
    thread_.take_reports(reports_);
    std::this_thread::sleep_for(1ms);
  }
  thread_.stop_job();
  settle();
  ASSERT_NE(last_report<action::ZoomEnded>(), nullptr);
  EXPECT_EQ(last_report<action::ZoomEnded>()->folder.empty(),
            !std::filesystem::exists(folder / "zoom"));
}

TEST_F(RenderThreadTest, errors_become_sentences_and_the_thread_lives_on) {
  thread_.run([](RenderContext&) { throw Error(ErrorKind::input, "scene.ply: is broken"); });
  settle();
  ASSERT_NE(last_report<action::Say>(), nullptr);
  EXPECT_EQ(last_report<action::Say>()->text, "scene.ply: is broken");
  EXPECT_TRUE(draw(order_));
}

TEST_F(RenderThreadTest, a_scene_that_does_not_fit_leaves_the_old_one) {
  LoadedScene loaded;
  loaded.scene.path = "/data/other.ply";
  thread_.run(open_scene(std::move(loaded), Backend::cuda, {}, false));
  settle();
  if (last_report<action::SceneOpened>()->backend == Backend::cuda) GTEST_SKIP() << "a GPU is here";
  EXPECT_EQ(last_report<action::SceneOpened>()->scene.name, "random");
  EXPECT_TRUE(last_report<action::Say>()->error);
  EXPECT_TRUE(draw(order_));
}

}  // namespace
}  // namespace qs
