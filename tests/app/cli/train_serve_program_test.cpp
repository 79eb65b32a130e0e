// SPDX-License-Identifier: MIT
// Needs QUADSPLAT_SERVE.
//
// train --serve as a program. server_test.cpp tests what its visitors see.
#include <csignal>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/remote/tcp.h"
#include "app/support/run_program.h"
#include "app/support/training.h"
#include "support/scene_files.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

class TrainServe : public testing::Test {
 protected:
  TemporaryFolder folder_;

  test::ProgramRun train(const std::string& name, const std::vector<std::string>& more,
                         const std::function<void(pid_t)>& meanwhile = {}) {
    if (!std::filesystem::exists(folder_ / "data"))
      test::write_data_set(test::data_set_of(test::ball_of_gaussians(200, 1), 12),
                           folder_ / "data");
    std::vector<std::string> words = {
        "train", (folder_ / "data").string(), "--out-dir", (folder_ / name).string(), "--threads",
        "2",     "--random-points",           "200"};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_quadsplat(words, meanwhile);
  }
  std::string model_of(const std::string& name) {
    return test::content_of(folder_ / name / "point_cloud/iteration_30/point_cloud.ply");
  }
};

TEST_F(TrainServe, the_model_is_the_same_to_the_byte) {
  const auto served = train("served", {"--iterations", "30", "--serve", "--port", "0"});
  ASSERT_EQ(served.exit_code, 0) << served.err;
  EXPECT_THAT(served.out, HasSubstr("http://127.0.0.1:"));
  EXPECT_THAT(served.err, HasSubstr("serving the training; Ctrl+C ends it"));
  ASSERT_EQ(train("plain", {"--iterations", "30"}).exit_code, 0);
  EXPECT_FALSE(model_of("plain").empty());
  EXPECT_EQ(model_of("served"), model_of("plain"));
}

TEST_F(TrainServe, a_signal_saves_the_run_and_says_how_to_continue) {
  const auto run =
      train("stopped", {"--iterations", "1000000", "--serve", "--port", "0"}, [&](pid_t pid) {
        const auto log = folder_ / "stopped" / "cfg_args";
        for (int i = 0; i < 6000 && !std::filesystem::exists(log); ++i)
          std::this_thread::sleep_for(std::chrono::milliseconds(10));
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        ::kill(pid, SIGINT);
      });
  EXPECT_EQ(run.exit_code, 130) << run.err;
  EXPECT_THAT(run.out, HasSubstr("interrupted; to continue: quadsplat train"));
  EXPECT_THAT(run.out, HasSubstr("--serve"));
}

TEST_F(TrainServe, what_does_not_fit_is_refused) {
  const auto refusal = [&](const std::vector<std::string>& more, int code = 1) {
    const auto run = train("refused", more);
    EXPECT_EQ(run.exit_code, code);
    return run.err;
  };
  for (const char* port : {"7008", "7007", "0"})  // also the default
    EXPECT_THAT(refusal({"--port", port}), HasSubstr("train: --port: needs --serve"));
  EXPECT_THAT(refusal({"--address", "::1"}), HasSubstr("train: --address: needs --serve"));
  EXPECT_THAT(refusal({"--name", "gpu7"}), HasSubstr("train: --name: needs --serve"));
  EXPECT_THAT(refusal({"--certificate", "c.pem"}),
              HasSubstr("train: --certificate: needs --serve"));
  EXPECT_THAT(refusal({"--key", "k.pem"}), HasSubstr("train: --key: needs --serve"));
  EXPECT_THAT(refusal({"--serve", "--view"}),
              HasSubstr("train: --serve and --view exclude each other"));
  const TcpSocket taken = listen_on_loopback(0, "test");
  EXPECT_THAT(refusal({"--serve", "--port", std::to_string(taken.port())}, 3),
              ContainsRegex("train: 127.0.0.1 port [0-9]+ cannot be used: Address already in use"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "refused"));
}

}  // namespace
}  // namespace qs
