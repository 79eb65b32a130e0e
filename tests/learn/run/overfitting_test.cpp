// SPDX-License-Identifier: MIT
// Runs say where the test views got worse, and keep the best evaluation.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/report/train_page.h"
#include "app/support/training.h"
#include "io/bytes/json_text.h"
#include "learn/run/model_folder.h"
#include "learn/run/run.h"
#include "learn/run/train_log.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs::train {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

DataSet data_with(std::size_t training, std::size_t test) {
  DataSet data;
  data.training.resize(training);
  data.test.resize(test);
  return data;
}

LogRow row_at(int iteration, double psnr) { return {iteration, 1, 0.1, 9, Quality{psnr, 0.9}}; }

TEST(Overfitting, the_best_evaluation_is_kept_by_default_with_few_photographs) {
  EXPECT_TRUE(keeps_best_by_default(data_with(104, 15)));
  EXPECT_FALSE(keeps_best_by_default(data_with(105, 15)));
  EXPECT_FALSE(keeps_best_by_default(data_with(20, 0))) << "there is no evaluation";
}

TEST(Overfitting, evaluations_are_as_far_apart_as_their_number_of_test_views_needs) {
  EXPECT_EQ(evaluation_interval(data_with(1, 1), "cpu"), 1000);
  EXPECT_EQ(evaluation_interval(data_with(84, 13), "cpu"), 1000);
  EXPECT_EQ(evaluation_interval(data_with(500, 100), "cpu"), 2000);
  EXPECT_EQ(evaluation_interval(data_with(84, 13), "cuda, GPU"), 1000);
  EXPECT_EQ(evaluation_interval(data_with(500, 100), "cuda, GPU"), 3000);
  EXPECT_EQ(evaluation_interval(data_with(9, 0), "cuda, GPU"), 1000);
}

TEST(Overfitting, a_sentence_names_the_best_iteration_and_how_to_keep_or_open_it) {
  const TemporaryFolder folder;
  TrainLog log;
  EXPECT_EQ(overfitting_sentence(log, folder.path()), "");
  log.rows = {{100, 1, 0.5, 9, {}}};
  EXPECT_EQ(overfitting_sentence(log, folder.path()), "") << "nothing was evaluated";
  log.rows = {row_at(7000, 28.5), row_at(14'000, 28.3125), {14'100, 1, 0.5, 9, {}}};
  EXPECT_EQ(overfitting_sentence(log, folder.path()), "") << "less than 0.2 dB";
  log.rows[1].test->psnr = 28.25;
  EXPECT_EQ(overfitting_sentence(log, folder.path()),
            "overfitting: the test views have lost 0.25 dB since iteration 7,000 (28.50 dB, now "
            "28.25 dB); --keep-best saves the best iteration of a run");
  const auto saved = gaussians_path(folder.path(), 7000);
  std::filesystem::create_directories(saved.parent_path());
  std::ofstream(saved) << "ply";
  EXPECT_THAT(overfitting_sentence(log, folder.path()),
              testing::EndsWith("; it is saved, and --iteration 7000 opens it"));
  log.rows.push_back(row_at(21'000, 29));
  EXPECT_EQ(overfitting_sentence(log, folder.path()), "") << "the last evaluation is the best";
}

/// Continues a run that was evaluated with `psnr` until iteration 1,002. Returns its stdout.
std::string continued(const std::filesystem::path& folder, double psnr,
                      std::optional<bool> keep_best) {
  const DataSet data = test::data_set_of(test::ball_of_gaussians(20, 1), 8);
  TrainSettings settings;
  settings.sh_degree = 0;
  settings.iterations = 1002;
  settings.max_gaussians = 20;
  ModelState model = ModelState::starting_with(test::ball_of_gaussians(20, 1));
  model.iteration = 998;
  TrainLog log;
  log.rows = {row_at(400, psnr)};
  std::filesystem::create_directories(folder);
  write_checkpoint({settings, data.fingerprint(), log, model}, checkpoint_path(folder));
  RunOptions options;
  options.out_dir = folder;
  options.resume = true;
  options.keep_best = keep_best;
  options.keep_checkpoint = true;
  options.write_page = write_train_page;
  testing::internal::CaptureStdout();
  run_training(settings, data, options, make_training_model(Backend::cpu, test::pool()),
               test::pool());
  return testing::internal::GetCapturedStdout();
}

TEST(Overfitting, the_last_lines_of_a_run_and_its_page_say_it) {
  const TemporaryFolder folder;
  const auto say_it = AllOf(HasSubstr("overfitting: the test views have lost "),
                            HasSubstr("since iteration 400 (99.00 dB"));
  EXPECT_THAT(continued(folder / "worse", 99, {}),
              AllOf(say_it, HasSubstr("best on the test views: iteration 400, 99.00 dB")));
  EXPECT_THAT(read_text_file(folder / "worse" / "train.html", 1 << 20), say_it);
  EXPECT_THAT(continued(folder / "better", 1, {}), Not(HasSubstr("overfitting")));
  EXPECT_THAT(read_text_file(folder / "better" / "train.html", 1 << 20),
              Not(HasSubstr("overfitting")));
}

TEST(Overfitting, a_run_with_few_photographs_evaluates_by_itself_and_keeps_the_best) {
  const TemporaryFolder folder;
  for (const auto& [keep_best, keeps] : {std::pair{std::optional<bool>(), true},
                                         {std::optional(true), true},
                                         {std::optional(false), false}}) {
    const auto model = folder / (keep_best ? (keeps ? "best" : "last") : "usual");
    EXPECT_EQ(testing::Matches(HasSubstr("iteration 1,000: PSNR "))(continued(model, 1, keep_best)),
              keeps);
    EXPECT_EQ(std::filesystem::exists(gaussians_path(model, 1000)), keeps);
    EXPECT_TRUE(std::filesystem::exists(gaussians_path(model, 1002)));
    const Checkpoint end = read_checkpoint(checkpoint_path(model));
    EXPECT_GT(end.log.evaluation_seconds, 0);
  }
}

}  // namespace
}  // namespace qs::train
