// SPDX-License-Identifier: MIT
// Training by the library, against the program.
#include <cmath>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "app/support/run_program.h"
#include "library/opened_scene.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using quadsplat::check;
using testing::HasSubstr;

/// A data set of small photographs of the bundled scene, and runs with it.
class LibraryTraining : public testing::Test {
 protected:
  LibraryTraining() {
    std::filesystem::create_directories(data() / "images");
    std::filesystem::copy_file(test::plush_cameras(), data() / "cameras.json");
    quadsplat::Scene scene = context_.load(test::plush().string());
    std::vector<std::string> names;
    const std::vector<QsCamera> cameras =
        quadsplat::read_cameras(test::plush_cameras().string(), &names);
    for (std::size_t i = 0; i < 9; ++i) {
      QsCamera camera = cameras[i];
      check(qs_camera_resize, &camera, camera.width / 16, camera.height / 16);
      std::vector<float> values = test::colors(scene, camera);
      const QsArray picture = quadsplat::array_of(values.data(), {camera.height, camera.width, 3});
      check(qs_picture_save, &picture, (data() / "images" / (names[i] + ".png")).c_str(), 1u);
    }
  }

  std::filesystem::path data() const { return folder_ / "data"; }
  std::filesystem::path model(const std::string& name) const { return folder_ / name; }
  std::string gaussians(const std::string& name, int iteration) const {
    return test::content_of(model(name) / "point_cloud" /
                            ("iteration_" + std::to_string(iteration)) / "point_cloud.ply");
  }

  /// Trains into the folder. Returns the sentence of the error.
  std::string train(const std::string& name, const std::vector<QsOption>& options,
                    std::int32_t code = QS_OK) {
    const std::string data_path = data().string(), model_path = model(name).string();
    auto training = quadsplat::sized<QsTraining>();
    training.data = data_path.c_str();
    training.model = model_path.c_str();
    training.options = options.data();
    training.option_count = options.size();
    training.user = this;
    training.progress = [](void* user, const QsTrainingState* state) {
      auto& self = *static_cast<LibraryTraining*>(user);
      EXPECT_EQ(std::this_thread::get_id(), self.thread_);
      self.iterations_.push_back(state->iteration);
      if (state->iteration == self.stops_context_at_) self.context_.stop();
      return std::int32_t{state->iteration == self.ends_at_};
    };
    training.text = [](void* user, const char* sentence) {
      static_cast<LibraryTraining*>(user)->text_ += std::string(sentence) + '\n';
    };
    iterations_.clear();
    text_.clear();
    state_ = quadsplat::sized<QsTrainingState>();
    char message[QS_MESSAGE_BYTES];
    EXPECT_EQ(qs_train(context_.get(), &training, &state_, message), code) << message;
    return message;
  }

  const TemporaryFolder folder_;
  quadsplat::Context context_ = test::cpu();
  const std::thread::id thread_ = std::this_thread::get_id();
  std::vector<std::int32_t> iterations_;
  std::string text_;
  QsTrainingState state_{};
  int ends_at_ = -1, stops_context_at_ = -1;
};

TEST_F(LibraryTraining, gives_the_bytes_of_the_program_and_is_silent) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  train("own", {{"iterations", "30"},
                {"random_points", "300"},
                {"--sh-degree", "1"},
                {"eval_every", "20"},
                {"step-before-densify", nullptr},
                {"final_prunes", "off"}});
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  const test::ProgramRun program = test::run_quadsplat(
      {"train", data().string(), "--out-dir", model("program").string(), "--iterations", "30",
       "--random-points", "300", "--sh-degree", "1", "--eval-every", "20", "--step-before-densify",
       "--threads", "1", "--backend", "cpu"});
  ASSERT_EQ(program.exit_code, 0) << program.err;
  EXPECT_FALSE(gaussians("own", 30).empty());
  EXPECT_TRUE(gaussians("own", 30) == gaussians("program", 30));
  for (const char* file : {"cameras.json", "input.ply"})
    EXPECT_TRUE(test::content_of(model("own") / file) == test::content_of(model("program") / file));
  EXPECT_FALSE(std::filesystem::exists(model("own") / "train.html"));
  EXPECT_THAT(text_, HasSubstr("training on cpu"));
  EXPECT_THAT(text_, HasSubstr("iteration 20: PSNR "));
  EXPECT_THAT(text_, HasSubstr("300 Gaussians, 30 iterations in "));
  EXPECT_EQ(iterations_.front(), 0);
  EXPECT_EQ(iterations_.back(), 30);
  EXPECT_EQ(state_.iteration, 30);
  EXPECT_EQ(state_.iterations, 30);
  EXPECT_EQ(state_.evaluated, 30);
  EXPECT_EQ(state_.gaussians, 300u);
  EXPECT_GT(state_.loss, 0);
  EXPECT_GT(state_.seconds, 0);
  EXPECT_GT(state_.test_psnr, 5);
  EXPECT_GT(state_.test_ssim, 0);
}

TEST_F(LibraryTraining, is_saved_when_it_is_stopped_and_continues_to_the_same_bits) {
  const std::vector<QsOption> options = {{"iterations", "12"}, {"random_points", "200"}};
  train("whole", options);
  ends_at_ = 5;
  EXPECT_EQ(train("parts", options, QS_CANCELLED), "cancelled");
  EXPECT_EQ(iterations_.back(), 5);
  EXPECT_EQ(state_.iteration, 5);
  EXPECT_TRUE(std::isnan(state_.test_psnr));
  EXPECT_FALSE(gaussians("parts", 5).empty());
  ends_at_ = -1;
  stops_context_at_ = 8;
  std::vector<QsOption> again = options;
  again.push_back({"resume", nullptr});
  train("parts", again, QS_CANCELLED);
  EXPECT_EQ(iterations_, (std::vector<std::int32_t>{5, 6, 7, 8}));
  stops_context_at_ = -1;
  train("parts", again);
  EXPECT_TRUE(gaussians("parts", 12) == gaussians("whole", 12));
  EXPECT_EQ(context_.backend(), QS_BACKEND_CPU) << "the context works";
  stops_context_at_ = 0;
  train("none", options, QS_CANCELLED);
  EXPECT_EQ(state_.iteration, 0);
}

TEST_F(LibraryTraining, replaces_a_model_with_the_option_overwrite_alone) {
  const std::vector<QsOption> options = {{"iterations", "4"}, {"random_points", "50"}};
  train("model", options);
  EXPECT_EQ(
      train("model", options, QS_USAGE),
      model("model").string() +
          ": this folder exists already and is not empty: choose another name, or replace its "
          "files with --overwrite");
  std::vector<QsOption> over = options;
  over.push_back({"overwrite", "on"});
  train("model", over);
  EXPECT_THAT(text_, HasSubstr("removed 1 saved iteration of an earlier run: 4"));
}

TEST_F(LibraryTraining, refuses_options_in_the_sentences_of_the_program) {
  const auto refused = [&](const char* name, const char* value) {
    return train("refused", {{"iterations", "4"}, {name, value}}, QS_USAGE);
  };
  const std::string where = "qs_train: training.options[1]: ";
  EXPECT_EQ(refused("strateg", "adc"),
            where + "there is no option '--strateg'; did you mean '--strategy'?");
  EXPECT_EQ(refused("backend", "cpu"), where + "--backend belongs to the context");
  EXPECT_EQ(refused("threads", "4"), where + "--threads belongs to the context");
  EXPECT_EQ(refused("out-dir", "x"), where + "there is no option '--out-dir'");
  EXPECT_EQ(refused("seed", nullptr), where + "--seed needs a value");
  EXPECT_EQ(refused("color_field", "yes"), where + "--color-field: 'yes' is none of on, off");
  EXPECT_EQ(refused("seed", "-1"), "--seed: '-1' is not a whole number from 0 to 2147483647");
  EXPECT_EQ(refused("color-field", "on"), "--color-field: is for --strategy mask, not paced");
  EXPECT_EQ(refused(nullptr, "1"), "qs_train: training.options[1].name: is null");
  EXPECT_FALSE(std::filesystem::exists(model("refused")));
  std::filesystem::remove_all(data() / "images");
  EXPECT_THAT(train("refused", {}, QS_INPUT), HasSubstr(data().string()));
  char message[QS_MESSAGE_BYTES];
  auto training = quadsplat::sized<QsTraining>();
  EXPECT_EQ(qs_train(context_.get(), &training, nullptr, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_train: training.data: is null");
  EXPECT_EQ(qs_train(nullptr, &training, nullptr, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_train: context: is null");
}

}  // namespace
}  // namespace qs
