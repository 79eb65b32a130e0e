// SPDX-License-Identifier: MIT
// Training in the window: the budget of drawing, the commands, the thread, and the whole program.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/driven_viewer.h"
#include "app/support/program_in_window.h"
#include "app/support/training.h"
#include "app/viewer/panel_model/panel_model.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/training_thread.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/training_actions.h"
#include "io/picture/image_file.h"
#include "io/scene/reader.h"
#include "raster/api/renderer.h"
#include "support/pool.h"

namespace qs {
namespace {

using test::Driven;
using test::DrivenScene;
using testing::ElementsAre;
using testing::HasSubstr;

// ---- budget -------------------------------------------------------------------------------------
TEST(DrawingBudget, work_that_waits_for_permission_takes_at_most_its_share) {
  for (const double most : {0.2, 0.5}) {
    DrawingBudget budget;
    double now = 100, spent = 0;
    for (int i = 0; i < 100; ++i) {
      while (!budget.allows(now)) now += 0.001;
      const double seconds = 0.01 + 0.03 * (i % 4);
      now += seconds;
      spent += seconds;
      budget.spent(now, seconds, most);
    }
    while (!budget.allows(now)) now += 0.001;
    EXPECT_NEAR(spent / (now - 100), most, 0.01);
    EXPECT_NEAR(budget.share(now), most, 0.1);
    EXPECT_EQ(budget.share(now + 10), 0);
  }
}

// ---- state --------------------------------------------------------------------------------------
struct DrivenTraining : DrivenScene {
  DrivenTraining() : DrivenScene(2) {
    apply(action::training_began, std::filesystem::path("/data/model"),
          std::shared_ptr<const TestViews>());
  }
  TrainingProgress at(int iteration) const {
    TrainingProgress progress;
    progress.iteration = iteration;
    progress.iterations = 3000;
    progress.loss = 0.25;
    progress.gaussians = 1234;
    return progress;
  }
};

TEST(TrainingState, commands_reach_the_host_in_the_phases_in_which_they_make_sense) {
  Driven without;
  without.press("Shift+T");
  EXPECT_TRUE(without.training.empty()) << "nothing is trained";
  DrivenTraining driven;
  EXPECT_TRUE(driven.viewer.panels.training);
  driven.press("Shift+T");
  driven.apply(action::command_training, TrainingCommand::resume);
  driven.apply(action::training_paused, true);
  driven.press("Ctrl+T");
  driven.press("Shift+T");
  driven.apply(action::command_training, TrainingCommand::pause);
  driven.apply(action::training_paused, false);
  driven.apply(action::command_training, TrainingCommand::save);
  driven.apply(action::command_training, TrainingCommand::stop);
  driven.apply(action::training_ended, std::string("stopped and saved"), false);
  driven.apply(action::command_training, TrainingCommand::stop);
  using enum TrainingCommand;
  EXPECT_THAT(driven.training, ElementsAre(pause, step, resume, save, stop));
}

TEST(TrainingState, a_run_starts_unless_one_is_under_way) {
  Driven driven;
  const TrainingRequest request{"garden", "model", {"--iterations", "9"}};
  driven.apply(action::start_training, request);
  EXPECT_THAT(driven.trained, ElementsAre(request));
  driven.apply(action::start_training, request);
  EXPECT_EQ(driven.trained.size(), 1u);
  EXPECT_THAT(driven.viewer.log.back().text, HasSubstr("stop that run first"));
  driven.apply(action::training_ended, std::string("finished and saved"), false);
  driven.apply(action::start_training, request);
  EXPECT_EQ(driven.trained.size(), 2u);
}

TEST(TrainingState, measuring_waits_and_scripts_wait_while_a_model_is_trained) {
  DrivenTraining driven;
  Viewer viewer = driven.viewer;
  viewer.panels.hud = true;
  viewer.shown.version = viewer.version;
  viewer.now = 1e3;
  EXPECT_FALSE(numbers_are_wanted(viewer));
  EXPECT_FALSE(is_settled(viewer));
  for (const TrainingPhase phase : {TrainingPhase::paused, TrainingPhase::ended}) {
    viewer.training->phase = phase;
    viewer.panels.hud = false;
    EXPECT_TRUE(is_settled(viewer));
    viewer.panels.hud = true;
    EXPECT_TRUE(numbers_are_wanted(viewer));
  }
}

TEST(TrainingState, another_model_needs_another_frame_and_both_take_from_the_budget) {
  DrivenTraining driven;
  EXPECT_TRUE(may_draw(driven.viewer));
  const int version = driven.viewer.version, view_version = driven.viewer.view_version;
  driven.apply(action::model_shown, 70, std::uint64_t{999}, 0.1);
  EXPECT_GT(driven.viewer.version, version);
  EXPECT_GT(driven.viewer.view_version, view_version);
  EXPECT_EQ(driven.viewer.scene->gaussians, 999u);
  EXPECT_EQ(driven.viewer.training->shown, 70);
  EXPECT_FALSE(may_draw(driven.viewer));
  Turn turn;
  turn.now = driven.viewer.now + 0.41;  // 0.1 s are a fifth of 0.5 s
  driven.apply(action::tick, turn, 0.41);
  EXPECT_TRUE(may_draw(driven.viewer));
  ShownFrame frame;
  frame.stats.frame_ms = 100;
  driven.apply(action::frame_shown, frame);
  EXPECT_FALSE(may_draw(driven.viewer));
  driven.apply(action::training_paused, true);
  EXPECT_TRUE(may_draw(driven.viewer)) << "nothing to take time from";
}

TEST(TrainingState, the_panel_says_how_far_training_is) {
  DrivenTraining driven;
  TrainingProgress progress = driven.at(1500);
  progress.test_psnr = 24.5;
  progress.test_ssim = 0.875;
  progress.evaluated = 1400;
  progress.iterations_per_second = 12.34;
  driven.apply(action::training_progressed, progress);
  std::map<std::string, std::string> facts;
  for (const Fact& fact : training_facts(driven.viewer)) facts[fact.label] = fact.value;
  EXPECT_EQ(facts["state"], "running");
  EXPECT_EQ(facts["iteration"], "1,500 of 3,000");
  EXPECT_EQ(facts["loss"], "0.2500");
  EXPECT_EQ(facts["test PSNR"], "24.50 dB, SSIM 0.8750 at iteration 1,400");
  EXPECT_EQ(facts["Gaussians"], "1,234");
  EXPECT_EQ(facts["speed"], "12.3 iterations/s");
  EXPECT_EQ(facts["drawing"], "0 % of the time");
  EXPECT_FALSE(facts.contains("test views"));
  progress.overfitting = "overfitting: the test views have lost 0.30 dB";
  driven.apply(action::training_progressed, progress);
  EXPECT_THAT(training_facts(driven.viewer),
              testing::Contains(testing::Field(&Fact::value, progress.overfitting)));
  progress.guard = "the 3 reserved views did not get worse";
  progress.test_psnrs = {{500, 22.5}, {1400, 24.5}};
  progress.reserved_psnrs = {{700, 21}, {1000, 22}};
  driven.apply(action::training_progressed, progress);
  EXPECT_THAT(training_facts(driven.viewer),
              testing::Contains(testing::Field(&Fact::value, progress.guard)));
  const Blocks blocks = training_blocks(driven.viewer);
  const auto* const chart = std::get_if<block::Chart>(&blocks.back());
  ASSERT_NE(chart, nullptr);
  ASSERT_EQ(chart->curves.size(), 2u);
  EXPECT_TRUE(chart->curves[0].is_dashed) << "reserved views";
  EXPECT_EQ(chart->curves[0].points[0].y, 0) << "21 dB, the least";
  EXPECT_NEAR(chart->curves[1].points[1].y, 3.5 / 4, 1e-9) << "of 21 to 25 dB";
  driven.apply(action::training_ended, std::string("no memory"), true);
  EXPECT_EQ(training_facts(driven.viewer)[0].value, "no memory");
  EXPECT_TRUE(driven.viewer.log.back().error);
}

// ---- the thread ---------------------------------------------------------------------------------
// A trainer that counts; its model has as many Gaussians as iterations, and one more.
class CountingRun {
 public:
  std::string operator()(TrainingThread& thread) {
    thread.began("/model", "/data", {});
    TrainingProgress progress;
    progress.iterations = 1'000'000'000;
    for (;; ++progress.iteration) {
      iteration = progress.iteration;
      const TrainingCommand wish = thread.after_iteration(progress, [&] {
        GaussianCloud cloud;
        cloud.positions.resize(static_cast<std::size_t>(progress.iteration) + 1);
        return cloud;
      });
      if (wish == TrainingCommand::stop) return "stopped";
      if (wish != TrainingCommand::save) continue;
      ++saves, --progress.iteration;
      if (resumes_while_saving) thread.command(TrainingCommand::resume);
    }
  }
  std::atomic<bool> resumes_while_saving = false;
  std::atomic<int> iteration = 0, saves = 0;
};

class TrainingThreadTest : public testing::Test {
 protected:
  // Takes reports until the state is as expected. The limit is far longer than a run.
  void wait_until(const std::function<bool()>& expected) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(100);
    while (!expected()) {
      ASSERT_LT(std::chrono::steady_clock::now(), end);
      Actions actions;
      thread_.take_reports(actions);
      driven_.apply_all(actions);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  TrainingPhase phase() const { return driven_.viewer.training->phase; }
  void pause() {
    thread_.command(TrainingCommand::pause);
    wait_until([&] {
      thread_.take_model();
      return phase() == TrainingPhase::paused && !thread_.busy();
    });
  }

  CountingRun run_;
  DrivenTraining driven_;
  TrainingThread thread_{[] {}, [this](TrainingThread& thread) { return run_(thread); }};
};

TEST_F(TrainingThreadTest, pauses_steps_resumes_saves_and_stops) {
  pause();
  const int paused_at = run_.iteration;
  EXPECT_EQ(driven_.viewer.training->progress.iteration, paused_at);
  thread_.command(TrainingCommand::save);
  wait_until([&] { return !thread_.busy(); });
  EXPECT_EQ(run_.saves, 1);
  EXPECT_EQ(run_.iteration, paused_at) << "saving trains nothing";
  for (int step = 1; step <= 2; ++step) {
    thread_.command(TrainingCommand::step);
    std::optional<TrainedModel> model;
    wait_until([&] { return (model = thread_.take_model()).has_value(); });
    EXPECT_EQ(model->iteration, paused_at + step);
    EXPECT_EQ(model->scene->cloud.size(), static_cast<std::size_t>(paused_at + step) + 1);
    wait_until([&] { return !thread_.busy(); });
    EXPECT_EQ(run_.iteration, paused_at + step);
  }
  thread_.command(TrainingCommand::resume);
  wait_until([&] { return phase() == TrainingPhase::running && run_.iteration > paused_at + 10; });
  thread_.command(TrainingCommand::stop);
  wait_until([&] { return phase() == TrainingPhase::ended; });
  EXPECT_EQ(driven_.viewer.training->outcome, "stopped");
}

TEST_F(TrainingThreadTest, says_that_it_runs_after_it_was_resumed_while_it_saved) {
  run_.resumes_while_saving = true;
  pause();
  thread_.command(TrainingCommand::save);
  wait_until([&] { return phase() == TrainingPhase::running; });
  EXPECT_EQ(run_.saves, 1);
}

TEST_F(TrainingThreadTest, copies_the_model_only_if_the_window_wants_one) {
  wait_until([&] { return thread_.take_model().has_value(); });
  const int seen = run_.iteration;
  wait_until([&] { return run_.iteration > seen + 50; });
  EXPECT_FALSE(thread_.take_model());
  thread_.want_model();
  std::optional<TrainedModel> model;
  wait_until([&] { return (model = thread_.take_model()).has_value(); });
  EXPECT_GT(model->iteration, seen);
}

// ---- the program --------------------------------------------------------------------------------
TEST(TrainingWindow, shows_pauses_steps_and_ends_with_the_bits_of_a_run_without_a_window) {
  if (!test::display().runs()) GTEST_SKIP() << "Xvfb is not installed";
  const TemporaryFolder folder;
  const auto path = [&](const std::string& name) { return (folder / name).string(); };
  test::write_data_set(test::data_set_of(test::ball_of_gaussians(200, 1), 12), folder / "data");
  test::write_scene(to_cloud(test::perturbed(test::ball_of_gaussians(200, 1), 2), false),
                    folder / "init.ply");
  std::ofstream(folder / "script")
      << "key Shift+T\nwait\nstate " << path("paused.json") << "\nkey Ctrl+T\nwait\nstate "
      << path("step.json") << "\nkey Shift+T\nwait\nstate " << path("ended.json") << "\nshot "
      << path("ended.png") << "\nquit\n";
  const auto train = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"train",        path("data"), "--out-dir", path(name),
                                      "--holdout",    "4",          "--init",    path("init.ply"),
                                      "--iterations", "100",        "--threads", "2",
                                      "--eval-every", "10"};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_quadsplat(words);
  };
  const auto run = train("window", {"--view", "--settings", "-", "--input", path("script")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto state = [&](const std::string& name) {
    return parse_json(read_text_file(folder / (name + ".json"), 1 << 20), "test");
  };
  EXPECT_EQ(state("paused")["training"]["state"], "paused");
  const int paused_at = state("paused")["training"]["shown"].get<int>();
  EXPECT_EQ(state("paused")["training"]["iteration"], fmt::format("{} of 100", paused_at));
  EXPECT_EQ(state("paused")["gaussians"], 200);
  EXPECT_EQ(state("step")["training"]["iteration"], fmt::format("{} of 100", paused_at + 1));
  EXPECT_EQ(state("step")["training"]["shown"], paused_at + 1);
  EXPECT_EQ(state("ended")["training"]["iteration"], "100 of 100");
  EXPECT_EQ(state("ended")["training"]["state"], "finished and saved");
  EXPECT_EQ(state("ended")["training"]["shown"], 100);
  EXPECT_THAT(state("ended")["training"]["test PSNR"].get<std::string>(),
              HasSubstr("at iteration 100"));
  EXPECT_EQ(state("ended")["scene"], "window");
  const Image shot = read_image(folder / "ended.png");
  EXPECT_GT(std::count_if(shot.values.begin(), shot.values.end(),
                          [](float value) { return value > 0.4f; }),
            1000);

  ASSERT_EQ(train("terminal", {}).exit_code, 0);
  const auto gaussians = [&](const std::string& name) {
    return read_text_file(folder / name / "point_cloud/iteration_100/point_cloud.ply", 1 << 26);
  };
  EXPECT_EQ(gaussians("window"), gaussians("terminal"));
}

// Photographs of a scene from two cameras: `first` and `second` are their sizes.
void write_photographs(const std::filesystem::path& folder, glm::ivec2 first, glm::ivec2 second) {
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(to_cloud(test::ball_of_gaussians(200, 1), false), {});
  std::filesystem::create_directories(folder / "images");
  std::vector<Camera> cameras;
  for (const glm::ivec2 size : {first, second}) {
    const double x = cameras.empty() ? 0 : 1;
    cameras.push_back(look_at({x, -1, -3}, {0, 0, 0}, {0, -1, 0}, 0.6, size.x, size.y));
    cameras.back().name = fmt::format("view{}", cameras.size());
    write_image(renderer->render(cameras.back()).color,
                folder / "images" / (cameras.back().name + ".png"));
  }
  test::write_cameras(cameras, folder / "cameras.json");
}

TEST(TrainingWindow, shows_a_test_view_with_the_numbers_of_the_evaluation) {
  if (!test::display().runs()) GTEST_SKIP() << "Xvfb is not installed";
  const TemporaryFolder folder;
  const auto path = [&](const std::string& name) { return (folder / name).string(); };
  test::write_scene(to_cloud(test::perturbed(test::ball_of_gaussians(200, 1), 2), false),
                    folder / "init.ply");
  std::ofstream(folder / "script") << "wait\ndrag 40 30 left\nwait\nstate " << path("moved.json")
                                   << "\nshot " << path("moved.png") << "\nquit\n";
  struct Case {
    glm::ivec2 test_view, training_view;
  };
  const Case cases[] = {{{400, 300}, {64, 48}},
                        {{4000, 300}, {90, 160}},  // wider than photographs are trained from
                        {{120, 400}, {64, 48}}};
  for (const Case& each : cases) {
    const std::string data = path("data") + std::to_string(each.test_view.x);
    write_photographs(data, each.test_view, each.training_view);
    for (const char* name : {"moved.json", "moved.png"}) std::filesystem::remove(folder / name);
    const auto run =
        test::run_quadsplat({"train", data, "--out-dir", data + "_model", "--holdout", "2",
                             "--init", path("init.ply"), "--iterations", "8", "--threads", "2",
                             "--view", "--settings", "-", "--input", path("script")});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto state = parse_json(read_text_file(folder / "moved.json", 1 << 20), "test");
    const nlohmann::json training = state["training"];
    EXPECT_EQ(training["state"], "finished and saved");
    EXPECT_EQ(training["view"], "test view view1 (1 of 1)");
    EXPECT_EQ(training["of this view"], "PSNR " + training["test PSNR"].get<std::string>());
  }
}

TEST(TrainingWindow, shows_a_training_view_if_none_is_held_out) {
  if (!test::display().runs()) GTEST_SKIP() << "Xvfb is not installed";
  const TemporaryFolder folder;
  const auto path = [&](const std::string& name) { return (folder / name).string(); };
  write_photographs(folder / "data", {64, 48}, {48, 64});
  std::ofstream(folder / "script") << "wait\nstate " << path("end.json") << "\nquit\n";
  const auto run =
      test::run_quadsplat({"train", path("data"), "--out-dir", path("model"), "--holdout", "0",
                           "--iterations", "3", "--random-points", "100", "--threads", "2",
                           "--view", "--settings", "-", "--input", path("script")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto training =
      parse_json(read_text_file(folder / "end.json", 1 << 20), "test")["training"];
  EXPECT_EQ(training["view"], "training view view1 (1 of 2)");
  EXPECT_THAT(training["of this view"].get<std::string>(), HasSubstr("at iteration 3"));
}

TEST(TrainingWindow, overwrites_an_earlier_run_and_opens_the_new_model) {
  if (!test::display().runs()) GTEST_SKIP() << "Xvfb is not installed";
  const TemporaryFolder folder;
  const auto path = [&](const std::string& name) { return (folder / name).string(); };
  write_photographs(folder / "data", {64, 48}, {48, 64});
  const std::vector<std::string> first = {"train",           path("data"),   "--out-dir",
                                          path("model"),     "--iterations", "9",
                                          "--random-points", "100"};
  ASSERT_EQ(test::run_quadsplat(first).exit_code, 0);
  std::ofstream(folder / "script") << "wait\nstate " << path("end.json") << "\nquit\n";
  const auto run = test::run_quadsplat(
      {"train", path("data"), "--out-dir", path("model"), "--iterations", "4", "--overwrite",
       "--random-points", "100", "--view", "--settings", "-", "--input", path("script")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(find_scene_file(folder / "model"),
            folder / "model/point_cloud/iteration_4/point_cloud.ply");
  const auto state = parse_json(read_text_file(folder / "end.json", 1 << 20), "test");
  EXPECT_THAT(state["toasts"].dump(), HasSubstr("removed 1 saved iteration of an earlier run: 9"));
}

TEST(TrainingWindow, prints_how_to_continue_if_it_was_closed_before_the_end) {
  if (!test::display().runs()) GTEST_SKIP() << "Xvfb is not installed";
  const TemporaryFolder folder;
  const std::string data = (folder / "my data").string(), model = (folder / "model").string();
  const std::string script = (folder / "script").string();
  test::write_data_set(test::data_set_of(test::ball_of_gaussians(200, 1), 12), data);
  std::ofstream(script) << "key Shift+T\nwait\nquit\n";
  const auto run = test::run_quadsplat({"train", data, "--out-dir", model, "--threads", "2",
                                        "--view", "--settings", "-", "--input", script});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(
      run.out,
      testing::EndsWith("stopped; to continue: quadsplat train '" + data + "' --out-dir " + model +
                        " --threads 2 --view --settings - --input " + script + " --resume\n"));
}

TEST(TrainingWindow, starts_from_the_menu_s_dialog_and_says_what_is_wrong) {
  if (!test::display().runs()) GTEST_SKIP() << "Xvfb is not installed";
  const TemporaryFolder folder;
  const auto path = [&](const std::string& name) { return (folder / name).string(); };
  test::write_data_set(test::data_set_of(test::ball_of_gaussians(200, 1), 12), folder / "data");
  // A shot waits until the window was drawn. Focus needs a few drawings, a key press one. A field
  // keeps its typed text, and typing replaces it.
  std::ofstream script(folder / "script");
  const auto train_from = [&](const std::string& data) {
    script << "key Ctrl+Shift+T\n";
    for (int i = 0; i < 4; ++i) script << "shot " << path("dialog.png") << "\n";
    script << "type " << path(data) << "\n";
    for (int i = 0; i < 2; ++i) script << "shot " << path("typed.png") << "\n";
    script << "key Enter\n";
    for (int i = 0; i < 2; ++i) script << "shot " << path("started.png") << "\n";
  };
  train_from("nothing");
  script << "wait\nstate " << path("refused.json") << "\n";
  train_from("data");
  script << "key Shift+T\nwait\nstate " << path("paused.json") << "\nquit\n";
  script.close();
  const auto run = test::run_quadsplat({"view", "--settings", path("settings.json"), "--threads",
                                        "2", "--input", path("script"), "--size", "800x500"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto state = [&](const std::string& name) {
    return parse_json(read_text_file(folder / (name + ".json"), 1 << 20), "test");
  };
  EXPECT_THAT(state("refused")["training"]["state"].get<std::string>(), HasSubstr("nothing"));
  const nlohmann::json training = state("paused")["training"];
  EXPECT_EQ(training["state"], "paused");
  EXPECT_THAT(training["iteration"].get<std::string>(), HasSubstr(" of 3,000"));
  EXPECT_EQ(training["model"], path("data_model"));
  EXPECT_EQ(state("paused")["scene"], "data_model");
  EXPECT_TRUE(std::filesystem::exists(folder / "data_model/checkpoint")) << "closing saves it";
}

}  // namespace
}  // namespace qs
