// SPDX-License-Identifier: MIT
// quadsplat train as users run it, on a synthetic data set.
#include <chrono>
#include <csignal>
#include <fstream>
#include <regex>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/run_program.h"
#include "app/support/training.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "raster/api/renderer.h"
#include "support/scene_files.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::ProgramRun;
using test::run_quadsplat;
using testing::HasSubstr;

class TrainProgram : public testing::Test {
 protected:
  void SetUp() override {
    test::write_data_set(test::data_set_of(test::ball_of_gaussians(200, 1), 12), data());
    test::write_scene(to_cloud(test::perturbed(test::ball_of_gaussians(200, 1), 2), false),
                      folder_ / "init.ply");
  }
  std::filesystem::path data() const { return folder_ / "data"; }
  std::filesystem::path model(const std::string& name) const { return folder_ / name; }

  ProgramRun train(const std::string& name, std::vector<std::string> more,
                   const std::function<void(pid_t)>& meanwhile = {}) const {
    std::vector<std::string> words = {
        "train", data().string(), "--out-dir", model(name).string(), "--holdout", "4"};
    if (!strategy_.empty() && std::ranges::find(more, "--strategy") == more.end())
      words.insert(words.end(), {"--strategy", strategy_});
    words.insert(words.end(), more.begin(), more.end());
    return run_quadsplat(words, meanwhile);
  }
  std::vector<std::string> start(int iterations) const {
    return {"--init", (folder_ / "init.ply").string(), "--iterations", std::to_string(iterations)};
  }
  static std::string bytes_of(const std::filesystem::path& path) {
    return read_text_file(path, 1 << 26);
  }
  std::string gaussians(const std::string& name, int iteration) const {
    return bytes_of(model(name) / "point_cloud" / ("iteration_" + std::to_string(iteration)) /
                    "point_cloud.ply");
  }

  TemporaryFolder folder_;
  std::string strategy_ = "adc";  ///< of runs that name none; "": the default
};

TEST_F(TrainProgram, a_model_is_not_written_into_its_data_set) {
  for (const std::filesystem::path& given : {data(), data() / "cameras.json"}) {
    const ProgramRun run = run_quadsplat({"train", given.string(), "--out-dir", data().string(),
                                          "--iterations", "1", "--overwrite"});
    EXPECT_EQ(run.exit_code, kExitUsage);
    EXPECT_EQ(run.err, "quadsplat: train: " + data().string() +
                           ": the model would be written into its data set\n");
  }
}

TEST_F(TrainProgram, writes_a_model_folder_that_eval_opens) {
  std::vector<std::string> words = start(60);
  words.insert(words.end(), {"--eval-every", "30", "--keep-best"});
  const ProgramRun run = train("model", words);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("iteration 30: PSNR "));
  EXPECT_THAT(run.out, HasSubstr(" on 3 test views, 200 Gaussians, "));
  EXPECT_THAT(run.out, HasSubstr("point_cloud/iteration_60/point_cloud.ply: 200 Gaussians"));
  const auto best = parse_json(bytes_of(model("model") / "train.json"), "test")["result"];
  EXPECT_THAT(run.out, HasSubstr("best on the test views: iteration " +
                                 best["best_iteration"].dump() + ", "));
  EXPECT_FALSE(gaussians("model", best["best_iteration"].get<int>()).empty());
  EXPECT_EQ(read_cameras(model("model")).size(), 12u);
  EXPECT_THAT(bytes_of(model("model") / "cfg_args"), HasSubstr("white_background=False"));
  EXPECT_THAT(bytes_of(model("model") / "train.csv"),
              testing::StartsWith("iteration,seconds,loss,gaussians,test_psnr,test_ssim\n30,"));
  const std::string page = bytes_of(model("model") / "train.html");
  EXPECT_THAT(page, HasSubstr("Training of model"));
  EXPECT_THAT(page, HasSubstr(">60</td>"));
  EXPECT_THAT(bytes_of(model("model") / "plots/loss.gp"), HasSubstr("$rows << END\n30 "));
  const auto report = parse_json(bytes_of(model("model") / "train.json"), "test");
  EXPECT_EQ(report["settings"]["strategy"], "adc");
  EXPECT_EQ(report["result"]["iteration"], 60);
  double seconds = 0;
  for (const auto& stage : report["result"]["stage_seconds"]) seconds += stage.get<double>();
  EXPECT_NEAR(seconds, report["result"]["seconds"].get<double>(), 1e-9);

  const ProgramRun eval =
      run_quadsplat({"eval", model("model").string(), "--images", (data() / "images").string(),
                     "--holdout", "4", "--backend", "cpu", "--json", "-"});
  ASSERT_EQ(eval.exit_code, 0) << eval.err;
  const auto measured = parse_json(eval.out, "test");
  EXPECT_NEAR(measured["means"][0]["psnr"].get<double>(),
              report["result"]["test_psnr"].get<double>(), 0.01);
}

TEST_F(TrainProgram, interrupted_run_is_saved_and_continues_to_the_same_bits) {
  std::vector<std::string> words = start(10'000'000);
  words.insert(words.end(), {"--threads", "2", "--eval-every", "100"});
  const ProgramRun stopped = train("parts", words, [&](pid_t process) {
    // The model folder appears when training begins.
    while (!std::filesystem::exists(model("parts") / "input.ply"))
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    kill(process, SIGINT);
  });
  EXPECT_EQ(stopped.exit_code, 130);
  EXPECT_THAT(stopped.err, HasSubstr("quadsplat: interrupted: "));
  EXPECT_THAT(stopped.err, HasSubstr(" finished files are kept, the last is "));
  EXPECT_THAT(stopped.out, HasSubstr("interrupted; to continue: quadsplat train " +
                                     data().string() + " --out-dir "));
  EXPECT_THAT(stopped.out, HasSubstr(" --resume\n"));
  const auto report = parse_json(bytes_of(model("parts") / "train.json"), "test");
  // Gaussians are added at 600.
  const int iterations = std::max(700, report["result"]["iteration"].get<int>() + 50);
  words = start(iterations);
  ASSERT_EQ(train("whole", words).exit_code, 0);
  words.emplace_back("--resume");
  const ProgramRun rest = train("parts", words);
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_EQ(gaussians("parts", iterations), gaussians("whole", iterations));
}

TEST_F(TrainProgram, resume_refuses_other_settings_data_and_damage) {
  EXPECT_THAT(train("none", {"--resume"}).err, HasSubstr("none: holds no run to continue"));
  std::vector<std::string> words = start(5);
  words.emplace_back("--keep-checkpoint");
  ASSERT_EQ(train("model", words).exit_code, 0);
  EXPECT_THAT(train("model", {"--iterations", "6", "--resume", "--seed", "1"}).err,
              HasSubstr("the run was started with other settings: seed"));
  EXPECT_THAT(train("model", {"--iterations", "6", "--resume", "--count-views", "mode",
                              "--opacity-rate", "0.05", "--step-before-densify"})
                  .err,
              HasSubstr("with other settings: count_views, step_before_densify, opacity_rate"));
  EXPECT_THAT(train("model", {"--iterations", "6", "--resume", "--resolution-scale", "2"}).err,
              HasSubstr("the run was started with other photographs, sizes or cameras"));
  const auto path = model("model") / "checkpoint";
  std::string bytes = bytes_of(path);
  bytes[bytes.size() - 100] = static_cast<char>(bytes[bytes.size() - 100] + 1);
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_THAT(train("model", {"--iterations", "6", "--resume"}).err,
              HasSubstr("checkpoint: is damaged: its hash does not match"));
  for (const std::size_t size : {0u, 5u, 12u, 200u, 5000u}) {
    std::ofstream(path, std::ios::binary) << bytes.substr(0, size);
    const ProgramRun run = train("model", {"--iterations", "6", "--resume"});
    EXPECT_EQ(run.exit_code, 2) << size;
    EXPECT_THAT(run.err, HasSubstr("model/checkpoint: "));
  }
}

TEST_F(TrainProgram, says_which_backend_trains_and_that_it_can_continue_on_another) {
  std::vector<std::string> words = start(2);
  words.insert(words.end(), {"--backend", "cpu", "--keep-checkpoint"});
  EXPECT_THAT(train("model", words).out, HasSubstr("training on cpu\n"));
  words = start(3);
  words.insert(words.end(), {"--resume", "--keep-checkpoint", "--backend"});
  for (const char* backend : {"auto", "cuda"}) {
    words.emplace_back(backend);
    const ProgramRun run = train("model", words);
    words.pop_back();
    if (std::string(backend) == "auto" || available_backends().front() == Backend::cuda) {
      EXPECT_EQ(run.exit_code, 0) << run.err;
      const std::string name = kBackendNames[static_cast<int>(available_backends().front())];
      EXPECT_THAT(run.out, HasSubstr("training on " + name));
    } else {
      EXPECT_EQ(run.exit_code, 3);
      EXPECT_THAT(run.err, HasSubstr("backend cuda: " + gpu_report().problem));
    }
  }
}

TEST_F(TrainProgram, never_writes_into_a_folder_with_files_unless_told_to) {
  std::filesystem::create_directories(model("mine"));
  std::ofstream(model("mine") / "cameras.json") << "mine";
  const ProgramRun refused = train("mine", start(2));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("mine: this folder exists already and is not empty"));
  EXPECT_EQ(bytes_of(model("mine") / "cameras.json"), "mine");
  EXPECT_EQ(train("data", start(2)).exit_code, 1);  // the data set
  std::vector<std::string> words = start(2);
  words.emplace_back("--overwrite");
  const std::string cameras = bytes_of(data() / "cameras.json");
  const ProgramRun onto_input = train("data", words);
  EXPECT_EQ(onto_input.exit_code, 1);
  EXPECT_THAT(onto_input.err, HasSubstr("the model would be written into its data set"));
  EXPECT_EQ(bytes_of(data() / "cameras.json"), cameras);
  EXPECT_EQ(train("mine", words).exit_code, 0);
  EXPECT_NE(bytes_of(model("mine") / "cameras.json"), "mine");
}

TEST_F(TrainProgram, overwriting_removes_the_iterations_of_the_earlier_run_and_nothing_else) {
  std::vector<std::string> words = start(6);
  words.insert(words.end(), {"--save-every", "2"});
  ASSERT_EQ(train("model", words).exit_code, 0);
  const std::filesystem::path place = model("model") / "point_cloud";
  const auto ply = [&](int iteration) {
    return place / ("iteration_" + std::to_string(iteration)) / "point_cloud.ply";
  };
  std::ofstream(place / "iteration_4/notes.txt") << "mine";
  std::filesystem::create_directories(place / "iteration_2000");
  std::string foreign = bytes_of(ply(2));
  foreign.erase(foreign.find("comment trained by quadsplat\n"), 29);
  std::ofstream(ply(2000), std::ios::binary) << foreign;
  words = start(3);
  words.emplace_back("--overwrite");
  const ProgramRun run = train("model", words);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("removed 3 saved iterations of an earlier run: 2, 4, 6\n"));
  EXPECT_THAT(run.err, HasSubstr("model: iteration 2000 does not say that quadsplat trained it"));
  EXPECT_FALSE(std::filesystem::exists(place / "iteration_2"));
  EXPECT_FALSE(std::filesystem::exists(place / "iteration_6"));
  EXPECT_FALSE(std::filesystem::exists(ply(4)));
  EXPECT_EQ(bytes_of(place / "iteration_4/notes.txt"), "mine");
  EXPECT_EQ(bytes_of(ply(2000)), foreign);
  std::filesystem::remove_all(place / "iteration_2000");
  EXPECT_EQ(find_scene_file(model("model")), ply(3)) << "the new model is opened";
}

TEST_F(TrainProgram, resuming_keeps_earlier_iterations_also_with_overwrite) {
  std::vector<std::string> words = start(4);
  words.emplace_back("--keep-checkpoint");
  ASSERT_EQ(train("model", words).exit_code, 0);
  words = start(6);
  words.insert(words.end(), {"--resume", "--overwrite"});
  const ProgramRun run = train("model", words);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, testing::Not(HasSubstr("removed")));
  EXPECT_FALSE(gaussians("model", 4).empty());
  EXPECT_FALSE(gaussians("model", 6).empty());
}

TEST_F(TrainProgram, a_finished_run_leaves_no_checkpoint_unless_told_to) {
  const auto checkpoint = model("model") / "checkpoint";
  std::vector<std::string> words = start(4);
  words.insert(words.end(), {"--save-every", "2"});
  ASSERT_EQ(train("model", words).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(checkpoint)) << "that of iteration 2 was removed";
  EXPECT_THAT(train("model", {"--iterations", "6", "--resume"}).err,
              HasSubstr("a finished run continues only if it had --keep-checkpoint"));
  words.insert(words.end(), {"--keep-checkpoint", "--overwrite"});
  ASSERT_EQ(train("model", words).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(checkpoint));
  words = start(6);
  words.emplace_back("--resume");
  ASSERT_EQ(train("model", words).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(checkpoint));
  // A file of somebody else with this name stays.
  std::ofstream(checkpoint) << "mine";
  words = start(2);
  words.emplace_back("--overwrite");
  ASSERT_EQ(train("model", words).exit_code, 0);
  EXPECT_EQ(bytes_of(checkpoint), "mine");
}

TEST_F(TrainProgram, two_runs_never_train_into_one_folder) {
  std::vector<std::string> words = start(10'000'000);
  const ProgramRun killed = train("model", words, [&](pid_t process) {
    while (!std::filesystem::exists(model("model") / "input.ply"))
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    for (const char* option : {"--overwrite", "--resume"}) {
      std::vector<std::string> again = start(2);
      again.emplace_back(option);
      if (option == std::string("--resume"))
        std::ofstream(model("model") / "checkpoint") << "a checkpoint";
      const ProgramRun second = train("model", again);
      EXPECT_EQ(second.exit_code, 1);
      EXPECT_EQ(second.err, "quadsplat: " + model("model").string() +
                                ": another process trains into this folder\n");
    }
    kill(process, SIGKILL);
  });
  EXPECT_NE(killed.exit_code, 0);
  // Nothing is left of the lock.
  words = start(2);
  words.emplace_back("--overwrite");
  const ProgramRun next = train("model", words);
  EXPECT_EQ(next.exit_code, 0) << next.err;
}

TEST_F(TrainProgram, settings_of_density_control_are_recorded) {
  std::vector<std::string> words = start(3);
  words.insert(words.end(),
               {"--count-views", "mode", "--step-before-densify", "--opacity-rate", "0.125"});
  ASSERT_EQ(train("model", words).exit_code, 0);
  const auto settings = parse_json(bytes_of(model("model") / "train.json"), "test")["settings"];
  EXPECT_EQ(settings["count_views"], "mode");
  EXPECT_EQ(settings["step_before_densify"], true);
  EXPECT_EQ(settings["opacity_rate"], 0.125);
  EXPECT_THAT(train("other", {"--opacity-rate", "0"}).err, HasSubstr("--opacity-rate"));
}

TEST_F(TrainProgram, overwriting_removes_no_model_that_it_starts_from) {
  ASSERT_EQ(train("model", start(4)).exit_code, 0);
  const std::string before = gaussians("model", 4);
  const ProgramRun run =
      train("model", {"--init", model("model").string(), "--iterations", "2", "--overwrite"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("iteration_4/point_cloud.ply: is an input of this command"));
  EXPECT_EQ(gaussians("model", 4), before);
}

TEST_F(TrainProgram, paths_in_cfg_args_are_literals_of_python) {
  const std::string name = "it's a \\ folder\n";
  ASSERT_EQ(train(name, start(2)).exit_code, 0);
  EXPECT_THAT(bytes_of(model(name) / "cfg_args"),
              HasSubstr("model_path='" + folder_.path().string() +
                        "/it\\'s a \\\\ folder\\x0a', images='images'"));
}

TEST_F(TrainProgram, refuses_options_that_its_strategy_does_not_read) {
  const auto expect_refused = [&](std::vector<std::string> words, const std::string& sentence) {
    const ProgramRun run = train("model", words);
    EXPECT_EQ(run.exit_code, 1) << sentence;
    EXPECT_THAT(run.err, HasSubstr(sentence));
    EXPECT_FALSE(std::filesystem::exists(model("model")));
  };
  expect_refused({"--gaussians", "few"}, "--gaussians: is for --strategy paced or fastgs, not adc");
  expect_refused({"--gaussians", "900"}, "--gaussians N: is for --strategy paced, not adc");
  expect_refused({"--strategy", "mcmc", "--gaussians", "many"},
                 "--gaussians: is for --strategy paced or fastgs, not mcmc");
  expect_refused({"--gaussians", "some"}, "--gaussians: 'some' is not a whole number from 1 to");
  expect_refused({"--strategy", "fastgs", "--seconds", "5"},
                 "--seconds: is for --strategy paced, not fastgs");
  expect_refused({"--guard"}, "--guard: is for --strategy paced, not adc");
  expect_refused({"--pace", "train.json"}, "--pace: is for --strategy paced, not adc");
  expect_refused({"--strategy", "paced", "--seconds", "5", "--pace", "train.json"},
                 "--pace: contradicts --seconds");
  expect_refused({"--strategy", "paced", "--seconds", "5", "--resolution-schedule", "dash"},
                 "--resolution-schedule dash: contradicts --seconds");
  expect_refused({"--strategy", "paced", "--gaussians", "5", "--max-gaussians", "6"},
                 "--max-gaussians: contradicts --gaussians 5");
  expect_refused({"--strategy", "mcmc", "--absolute-gradients"},
                 "--absolute-gradients: is for --strategy adc, not mcmc");
  expect_refused({"--strategy", "fastgs", "--final-prunes"},
                 "--final-prunes: is for --strategy adc or mcmc, not fastgs");
  expect_refused({"--strategy", "dash", "--final-prunes"},
                 "--final-prunes: is for --strategy adc or mcmc, not dash");
  expect_refused({"--sum-gradients"}, "--sum-gradients: is for --strategy fastgs, not adc");
  expect_refused({"--color-field"}, "--color-field: is for --strategy mask, not adc");
  expect_refused({"--strategy", "mask", "--final-prunes"},
                 "--final-prunes: is for --strategy adc or mcmc, not mask");
  expect_refused({"--strategy", "mask", "--color-field", "--antialiased", "on"},
                 "--color-field: its files do not hold --antialiased");
  expect_refused({"--dash-variant", "current"}, "--dash-variant: is for --strategy dash, not adc");
  expect_refused({"--keep-best", "--keep-last"}, "--keep-last: contradicts --keep-best");
}

TEST_F(TrainProgram, paced_is_the_default_and_takes_its_length_and_number_from_the_data) {
  strategy_.clear();
  const auto run_with = [&](const std::string& name, std::vector<std::string> more) {
    more.insert(more.end(), {"--random-points", "20", "--seconds", "0.1"});
    const ProgramRun run = train(name, more);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out;
  };
  const std::string usual = run_with("usual", {});
  const auto report = parse_json(bytes_of(model("usual") / "train.json"), "test");
  EXPECT_EQ(report["settings"]["strategy"], "paced");
  std::smatch numbers;
  ASSERT_TRUE(std::regex_search(usual, numbers, std::regex("paced: 0.1 s, (\\d+) Gaussians\n")));
  const int number = std::stoi(numbers[1]);
  EXPECT_GT(number, 20);
  EXPECT_THAT(run_with("few", {"--gaussians", "few"}),
              HasSubstr(fmt::format("s, {} Gaussians\n", number / 2)));
  EXPECT_THAT(run_with("many", {"--gaussians", "many"}),
              HasSubstr(fmt::format("s, {} Gaussians\n", 2 * number)));
  EXPECT_THAT(run_with("less", {"--gaussians", "5"}),
              HasSubstr("s, 20 Gaussians, as at the start\n"));
}

TEST_F(TrainProgram, fastgs_trains_and_resumes_with_the_same_choice_of_gaussians_only) {
  const std::vector<std::string> words = {"--iterations", "3",          "--random-points",
                                          "500",          "--strategy", "fastgs",
                                          "--gaussians",  "many",       "--keep-checkpoint"};
  const ProgramRun run = train("model", words);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(parse_json(bytes_of(model("model") / "train.json"), "test")["settings"]["gaussians"],
            "many");
  const ProgramRun other =
      train("model", {"--iterations", "4", "--random-points", "500", "--strategy", "fastgs",
                      "--gaussians", "few", "--resume"});
  EXPECT_THAT(other.err, HasSubstr("the run was started with other settings: gaussians"));
}

TEST_F(TrainProgram, a_run_of_given_seconds_is_repeated_by_its_recorded_pace) {
  const auto run_with = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"--random-points", "200", "--strategy", "paced",
                                      "--gaussians",     "500", "--keep-last"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = train(name, words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return parse_json(bytes_of(model(name) / "train.json"), "test")["result"];
  };
  const auto timed = run_with("timed", {"--seconds", "2"});
  EXPECT_NEAR(timed["seconds"].get<double>(), 2, 1) << "a busy machine may miss a tenth";
  EXPECT_GT(timed["pace"].size(), 3u);
  EXPECT_EQ(timed["gaussians"], 500) << timed.dump();
  const std::string record = (model("timed") / "train.json").string();
  const auto repeated = run_with("repeated", {"--pace", record});
  EXPECT_EQ(repeated["iteration"], timed["iteration"]);
  const int last = timed["iteration"].get<int>();
  EXPECT_EQ(gaussians("repeated", last), gaussians("timed", last));
  // With the guard, which may stop growth before 500.
  const auto guarded = run_with("guarded", {"--pace", record, "--guard"});
  const auto again = run_with("guarded_again", {"--pace", record, "--guard"});
  EXPECT_GT(guarded["guard"].size(), 0u);
  EXPECT_EQ(again["guard"], guarded["guard"]);
  EXPECT_EQ(gaussians("guarded_again", last), gaussians("guarded", last));
  EXPECT_THAT(
      train("again", {"--strategy", "paced", "--pace", (model("repeated") / "train.json").string()})
          .err,
      HasSubstr("its run had no --seconds, so there is no pace to repeat"));
  EXPECT_THAT(
      train("again", {"--strategy", "paced", "--pace", (data() / "cameras.json").string()}).err,
      HasSubstr("is no train.json of a model"));
}

TEST_F(TrainProgram, dash_reduces_photographs_unless_told_otherwise_and_ends_where_it_began) {
  const auto schedule_of = [&](const char* name, std::vector<std::string> words) {
    words.insert(words.end(), {"--iterations", "3", "--random-points", "500", "--keep-checkpoint"});
    const ProgramRun run = train(name, words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return parse_json(bytes_of(model(name) / "train.json"),
                      "test")["settings"]["resolution_schedule"];
  };
  EXPECT_EQ(schedule_of("usual", {}), "full");
  EXPECT_EQ(schedule_of("reduced", {"--resolution-schedule", "dash"}), "dash");
  EXPECT_EQ(schedule_of("whole", {"--strategy", "dash", "--resolution-schedule", "full"}), "full");
  EXPECT_EQ(schedule_of("model", {"--strategy", "dash", "--dash-variant", "2025-06"}), "dash");
  const ProgramRun longer =
      train("model", {"--iterations", "4", "--random-points", "500", "--strategy", "dash",
                      "--dash-variant", "2025-06", "--resume"});
  EXPECT_THAT(longer.err, HasSubstr("the run was started with other settings: iterations"));
}

TEST_F(TrainProgram, starts_from_random_points_where_the_data_set_has_none) {
  const ProgramRun run =
      train("model", {"--iterations", "3", "--random-points", "500", "--strategy", "mcmc", "--cull",
                      "3dgs", "--antialiased", "on", "--background", "random"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(test::read_scene(model("model")).cloud.size(), 500u);
  EXPECT_TRUE(test::read_scene(model("model")).cloud.antialiased);
}

}  // namespace
}  // namespace qs
