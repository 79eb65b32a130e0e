// SPDX-License-Identifier: MIT
//
// The photograph beside the model's picture in the panel Training: the order of its steps, and the
// numbers of the comparison.
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "app/support/rendering_viewer.h"
#include "app/viewer/render/panel_pictures.h"
#include "app/viewer/state/charts.h"
#include "app/viewer/state/hud_text.h"
#include "base/fail.h"
#include "raster/scene/image_metrics.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

std::shared_ptr<TestViews> views_of(std::vector<Camera> cameras) {
  auto views = std::make_shared<TestViews>();
  for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i].name = fmt::format("view{}", i);
  views->cameras = std::move(cameras);
  views->read = [sizes = views->cameras](std::size_t view) {
    if (view == 2) fail("view2.png: is missing");
    return TestPhotograph{Image(sizes[view].width, sizes[view].height, 3), {}};
  };
  return views;
}

// ---- the order of the steps ---------------------------------------------------------------------
struct DrivenViews : test::DrivenScene {
  DrivenViews() : DrivenScene(3) {
    views = views_of(viewer.scene->cameras);
    apply(action::training_began, viewer.scene->path, std::shared_ptr<const TestViews>(views));
    apply(action::model_shown, 10, std::uint64_t{500}, 0.0);
    pass(100);
  }
  void pass(double seconds) {
    Turn turn;
    turn.now = viewer.now + seconds;
    apply(action::tick, turn, seconds);
  }
  void follow() { apply(action::follow_test_view); }
  void photograph_read(std::size_t view) {
    apply(action::test_photograph_read, std::shared_ptr<const TestViews>(views), view,
          std::make_shared<const TestPhotograph>(), std::make_shared<const Image>(4, 3, 3));
  }
  void compared(std::size_t view, int iteration) {
    const TestComparison comparison{view, iteration, std::make_shared<Image>(4, 3, 3), 20, 0.5};
    apply(action::test_view_compared, std::shared_ptr<const TestViews>(views), comparison, 0.0);
  }
  std::string text() const { return test_view_text(viewer); }

  std::shared_ptr<TestViews> views;
};

TEST(TestView, the_photograph_is_read_once_and_the_model_is_compared_once) {
  DrivenViews driven;
  EXPECT_EQ(test_view_title(*driven.viewer.training), "test view view0 (1 of 3)");
  EXPECT_EQ(driven.text(), "reading the photograph");
  for (int i = 0; i < 3; ++i) driven.follow();
  EXPECT_THAT(driven.test_photographs, ElementsAre(0u));
  EXPECT_THAT(driven.jobs_behind, SizeIs(0));
  driven.photograph_read(0);
  EXPECT_EQ(driven.text(), "drawing");
  for (int i = 0; i < 3; ++i) driven.follow();
  EXPECT_THAT(driven.jobs_behind, SizeIs(1));
  driven.compared(0, 10);
  EXPECT_EQ(driven.text(), "PSNR 20.00 dB, SSIM 0.5000 at iteration 10");
  for (int i = 0; i < 3; ++i) driven.follow();
  EXPECT_THAT(driven.jobs_behind, SizeIs(1)) << "the model has not changed";
}

TEST(TestView, another_model_is_compared_at_most_every_two_seconds_and_another_view_at_once) {
  DrivenViews driven;
  driven.follow();
  driven.photograph_read(0);
  driven.follow();
  driven.compared(0, 10);
  driven.apply(action::model_shown, 11, std::uint64_t{500}, 0.0);
  driven.pass(1.9);
  driven.follow();
  EXPECT_THAT(driven.jobs_behind, SizeIs(1));
  driven.pass(0.2);
  driven.follow();
  EXPECT_THAT(driven.jobs_behind, SizeIs(2));
  driven.compared(0, 11);
  driven.apply(action::step_test_view, 1);
  driven.follow();
  EXPECT_THAT(driven.test_photographs, ElementsAre(0u, 1u));
  driven.photograph_read(0);  // the first view's, which came late
  EXPECT_EQ(driven.text(), "reading the photograph");
  driven.photograph_read(1);
  driven.follow();
  EXPECT_THAT(driven.jobs_behind, SizeIs(3)) << "at once";
  driven.apply(action::model_shown, 12, std::uint64_t{500}, 0.0);
  driven.compared(1, 11);
  driven.apply(action::training_ended, std::string("finished and saved"), false);
  EXPECT_TRUE(test_view_is_pending(driven.viewer));
  driven.follow();
  EXPECT_THAT(driven.jobs_behind, SizeIs(4)) << "the last model is compared without a wait";
  driven.compared(1, 12);
  EXPECT_FALSE(test_view_is_pending(driven.viewer));
}

TEST(TestView, nothing_is_compared_while_the_camera_moves_or_the_window_has_something_else) {
  DrivenViews driven;
  driven.follow();
  driven.photograph_read(0);
  driven.apply(action::orbit, glm::dvec2(3, 4));
  driven.follow();
  EXPECT_THAT(driven.jobs_behind, SizeIs(0)) << "the camera moves";
  driven.pass(1);
  const auto with = [&](const std::function<void(Viewer&)>& edit) {
    DrivenViews other;
    other.follow();
    other.photograph_read(0);
    other.apply(edit);
    other.follow();
    return other.jobs_behind.size();
  };
  EXPECT_EQ(with([](Viewer& viewer) { viewer.panels.training = false; }), 0u);
  EXPECT_EQ(with([](Viewer& viewer) { viewer.panels.all = false; }), 0u);
  EXPECT_EQ(with([](Viewer& viewer) { viewer.scene->path = "/data/another.ply"; }), 0u);
  EXPECT_EQ(
      with([](Viewer& viewer) { viewer.crop.asked.gone = std::make_shared<const GaussianSet>(1); }),
      0u);
  EXPECT_EQ(with([](Viewer&) {}), 1u);
  driven.follow();
  EXPECT_THAT(driven.jobs_behind, SizeIs(1)) << "the camera rests";
  driven.apply(action::test_view_given_up);
  driven.follow();
  EXPECT_THAT(driven.jobs_behind, SizeIs(2)) << "a frame cancelled it";
}

TEST(TestView, a_photograph_that_cannot_be_read_gives_the_reason_and_is_not_read_again) {
  DrivenViews driven;
  driven.apply(action::step_test_view, -1);
  EXPECT_EQ(test_view_title(*driven.viewer.training), "test view view2 (3 of 3)") << "a circle";
  driven.follow();
  driven.apply(action::test_view_failed, std::shared_ptr<const TestViews>(driven.views),
               std::size_t{2}, std::string("view2.png: is missing"));
  driven.follow();
  EXPECT_EQ(driven.text(), "view2.png: is missing");
  EXPECT_FALSE(test_view_is_pending(driven.viewer)) << "scripts need not wait";
  EXPECT_THAT(driven.test_photographs, ElementsAre(2u));
  driven.apply(action::step_test_view, 1);
  EXPECT_EQ(test_view_title(*driven.viewer.training), "test view view0 (1 of 3)");
  EXPECT_EQ(driven.text(), "reading the photograph");
}

TEST(TestView, a_run_without_held_out_views_says_so) {
  DrivenViews driven;
  driven.views->held_out = false;
  EXPECT_EQ(test_view_title(*driven.viewer.training), "training view view0 (1 of 3)");
}

// ---- reading, drawing and comparing -------------------------------------------------------------
TEST(TestView, the_reader_gives_the_newest_photograph_and_errors) {
  const auto views = views_of(std::vector<Camera>(3, test::front_camera(8, 6)));
  test::Driven driven;
  driven.apply(action::training_began, std::filesystem::path("/data/model"),
               std::shared_ptr<const TestViews>(views));
  driven.apply(action::step_test_view, 2);
  PhotographReader reader([] {});
  for (const std::size_t view : {0u, 1u, 2u}) reader.read(read_test_photograph(views, view));
  while (reader.busy()) {
    Actions actions;
    reader.take_reports(actions);
    driven.apply_all(actions);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(driven.viewer.training->test_view.problem, "view2.png: is missing");
  EXPECT_EQ(driven.viewer.training->test_view.photograph, nullptr);
}

TEST(TestView, pictures_are_reduced_to_the_panel_with_their_shape) {
  const auto size = [](int width, int height) {
    const auto shown = shown_in_panel(Image(width, height, 3), test::pool());
    return std::pair(shown->width, shown->height);
  };
  EXPECT_EQ(size(400, 300), std::pair(400, 300));
  EXPECT_EQ(size(4000, 3000), std::pair(1024, 768));
  EXPECT_EQ(size(2000, 4000), std::pair(512, 1024));
  EXPECT_EQ(size(5000, 1), std::pair(1024, 1));
}

class RenderedTestView : public test::RenderingViewer {
 protected:
  void run_behind(Job job) override { thread_.run_behind(std::move(job)); }
  void read_test_photograph(const std::shared_ptr<const TestViews>&, std::size_t) override {}
};

TEST_F(RenderedTestView, the_numbers_are_those_of_the_view_s_own_camera) {
  Camera portrait = test::front_camera(60, 90);
  const auto views = views_of({portrait});
  views->settings.background = {0.2f, 0.4f, 0.6f};
  apply(
      call(action::training_began, viewer().scene->path, std::shared_ptr<const TestViews>(views)));
  apply(call(action::training_ended, std::string("finished"), false));
  apply(call(action::model_shown, 7, std::uint64_t{300}, 0.0));
  thread_.run([](RenderContext& context) { context.trained_iteration = 7; });
  auto photograph = std::make_shared<TestPhotograph>();
  photograph->image = Image(60, 90, 3);
  std::fill(photograph->image.values.begin(), photograph->image.values.end(), 0.5f);
  apply(call(action::test_photograph_read, std::shared_ptr<const TestViews>(views), std::size_t{0},
             std::shared_ptr<const TestPhotograph>(photograph),
             shown_in_panel(photograph->image, test::pool())));
  change([](Viewer& viewer) { viewer.now = 100; });
  apply(call(action::orbit, glm::dvec2(30, 40)));  // of the window alone
  change([](Viewer& viewer) {
    viewer.training->test_view.asked = true;
    viewer.now = 200;
  });
  apply(call(action::follow_test_view));
  settle();
  const TestComparison& comparison = viewer().training->test_view.comparison;
  ASSERT_TRUE(comparison.picture);
  EXPECT_EQ(comparison.iteration, 7);
  EXPECT_EQ(comparison.picture->width, 60);
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::random_cloud(300, 1, 5), {});
  Image expected = renderer->render(portrait, views->settings).color;
  clamp_to_unit(expected);
  EXPECT_NEAR(comparison.psnr, psnr(expected, photograph->image, test::pool()), 1e-9);
  EXPECT_NEAR(comparison.ssim, ssim(expected, photograph->image, test::pool()), 1e-9);
  EXPECT_FALSE(viewer().training->test_view.compares);
}

TEST_F(RenderedTestView, a_frame_goes_first_and_cancels_a_job_behind_the_frames) {
  std::atomic<int> began = 0, given_up = 0;
  thread_.run_behind([&](RenderContext& context) {
    ++began;
    while (!context.stop.stop_requested())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ++given_up;
    throw Cancelled{};
  });
  while (began == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_TRUE(draw(request_)) << "the frame comes";
  EXPECT_EQ(given_up, 1);
  std::vector<int> order;
  thread_.run([&](RenderContext&) {
    thread_.run_behind([&](RenderContext&) { order.push_back(2); });
    thread_.run([&](RenderContext&) { order.push_back(1); });
  });
  settle();
  EXPECT_THAT(order, ElementsAre(1, 2));
}

// ---- the loss -----------------------------------------------------------------------------------
TEST(LossChart, keeps_the_whole_run_and_the_newest_loss) {
  test::Driven driven;
  driven.apply(action::training_began, std::filesystem::path("/data/model"),
               std::shared_ptr<const TestViews>());
  for (int iteration = 1; iteration <= 5000; ++iteration) {
    TrainingProgress progress;
    progress.iteration = iteration;
    progress.iterations = 5000;
    progress.loss = 1.0 / iteration;
    driven.apply(action::training_progressed, progress);
    const auto& losses = driven.viewer.training->losses;
    ASSERT_LE(losses.size(), Training::kMostLosses);
    ASSERT_EQ(losses.back().iteration, iteration);
  }
  const auto& losses = driven.viewer.training->losses;
  EXPECT_GT(losses.size(), Training::kMostLosses / 3);
  EXPECT_LT(losses.front().iteration, 100);
  for (std::size_t i = 1; i < losses.size(); ++i)
    ASSERT_LT(losses[i - 1].iteration, losses[i].iteration);
}

TEST(LossChart, has_round_ticks_from_zero_to_beyond_the_largest_loss) {
  const IterationChart chart = loss_chart({{100, 0.31f}, {7000, 0.05f}});
  const auto texts = [](const std::vector<AxisTick>& ticks) {
    std::vector<std::string> result;
    for (const AxisTick& tick : ticks) result.push_back(tick.text);
    return result;
  };
  EXPECT_EQ(chart.value_ticks.front().value, 0);
  EXPECT_GE(chart.most, 0.31);
  EXPECT_GE(chart.most_iteration, 7000);
  EXPECT_THAT(texts(chart.iteration_ticks), testing::Contains("2,000"));
  for (const AxisTick& tick : loss_chart({{1, 0.0f}, {2, NAN}}).iteration_ticks)
    EXPECT_EQ(tick.value, std::floor(tick.value)) << "iterations are whole numbers";
  EXPECT_EQ(loss_near({{100, 0.3f}, {200, 0.2f}}, 130).iteration, 100);
}

}  // namespace
}  // namespace qs
