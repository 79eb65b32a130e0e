// SPDX-License-Identifier: MIT
//
// The dialog Train: its fields become the options of `train`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/viewer/state/training.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/state/viewer.h"
#include "learn/run/strategy.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(TrainForm, gives_no_options_for_defaults) {
  TrainForm form;
  form.data = "garden/";
  const TrainingRequest request = request_of(form);
  EXPECT_EQ(request.data, "garden/");
  EXPECT_EQ(request.model, "garden_model");
  EXPECT_THAT(request.options, IsEmpty());
}

TEST(TrainForm, gives_the_options_of_its_fields_and_then_the_typed_ones) {
  TrainForm form;
  form.data = "garden";
  form.model = "my model";
  form.iterations = 7000;
  form.size = 2;
  form.strategy = 2;
  form.more = "--masks \"my masks\"  --eval-every 5000";
  const TrainingRequest request = request_of(form);
  EXPECT_EQ(request.model, "my model");
  EXPECT_THAT(request.options,
              ElementsAre("--iterations", "7000", "--resolution-scale", "2", "--strategy", "mcmc",
                          "--masks", "my masks", "--eval-every", "5000"));
}

TEST(TrainForm, offers_the_strategies_of_the_command_line) {
  std::vector<std::string> offered;
  TrainForm form;
  for (form.strategy = 0; form.strategy < train::strategies().size(); ++form.strategy) {
    const std::vector<std::string> options = request_of(form).options;
    if (options.empty()) {
      offered.emplace_back("the default");
    } else {
      EXPECT_EQ(options.front(), "--strategy");
      offered.push_back(options.back());
    }
  }
  EXPECT_THAT(offered, ElementsAre("the default", "adc", "mcmc", "dash", "fastgs", "mask"));
}

TEST(TrainForm, quotes_keep_blanks_and_a_backslash_keeps_a_quote) {
  EXPECT_THAT(words_of("a \"b c\" d"), ElementsAre("a", "b c", "d"));
  EXPECT_THAT(words_of("\"say \\\"x\\\"\""), ElementsAre("say \"x\""));
  EXPECT_THAT(words_of("  "), IsEmpty());
  EXPECT_THAT(words_of("\"open end"), ElementsAre("open end"));
}

TEST(TrainingFacts, give_the_time_left_once_the_speed_is_known) {
  Viewer viewer;
  Training& training = viewer.training.emplace();
  training.progress = {1000, 7000, 0.1, 5000, 0, {}, {}, 0};
  const auto left = [&] {
    for (const Fact& fact : training_facts(viewer))
      if (fact.label == "time left") return fact.value;
    return std::string("-");
  };
  EXPECT_EQ(left(), "-");
  training.progress.iterations_per_second = 100;
  EXPECT_EQ(left(), "about 1 min");
  training.phase = TrainingPhase::ended;
  EXPECT_EQ(left(), "-");
}

}  // namespace
}  // namespace qs
