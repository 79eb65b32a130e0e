// SPDX-License-Identifier: MIT
//
// The viewer of a training in another program, against a trainer in Python.
#include "app/remote/remote_training.h"

#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/run_program.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"
#include "support/paths.h"

namespace qs {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

bool until(const std::function<bool()>& holds) {
  const auto end = std::chrono::steady_clock::now() + 120s;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

RemoteTimes short_times() {
  RemoteTimes times;
  times.visit = 50ms;
  times.pause_turn = 5ms;
  times.silence = 300ms;
  return times;
}

RemoteView view_of(int version) {
  RemoteView view;
  view.camera = look_at({0, 0, -3}, {0, 0, 0}, {0, -1, 0}, 1, 32, 24);
  view.version = version;
  return view;
}

TcpAddress address_at(int port) { return resolve("127.0.0.1:" + std::to_string(port), "test"); }

int iteration_of(const RemotePicture& picture) {
  return picture.rgba[0] | picture.rgba[1] << 8 | picture.rgba[2] << 16;
}

class RemotePeer : public testing::Test {
 protected:
  TemporaryFolder folder_;
  nlohmann::json log_;

  void SetUp() override {
    if (test::run_program("python3", {"--version"}).exit_code == 127)
      GTEST_SKIP() << "python3 is not installed";
  }

  // Runs the trainer, calls the function with its address, and reads the trainer's log.
  void with_trainer(const std::string& dialect, const std::vector<std::string>& more,
                    const std::function<void(const TcpAddress&)>& meanwhile) {
    const auto port_file = folder_ / "port", log_file = folder_ / "log";
    std::vector<std::string> words = {test::source_path("tests/support/network_gui_peer.py").string(),
                                      dialect, port_file.string(), log_file.string()};
    words.insert(words.end(), more.begin(), more.end());
    const auto run = test::run_program("python3", words, [&](pid_t pid) {
      ASSERT_TRUE(until([&] { return std::filesystem::exists(port_file); }));
      meanwhile(address_at(std::stoi(test::content_of(port_file))));
      ::kill(pid, SIGTERM);
    });
    EXPECT_EQ(run.exit_code, 0) << run.err;
    log_ = nlohmann::json::parse(test::content_of(log_file));
  }

  static std::optional<RemotePicture> next_picture(RemoteTraining& training) {
    std::optional<RemotePicture> picture;
    EXPECT_TRUE(until([&] { return (picture = training.take_picture()).has_value(); }))
        << training.run().problem;
    return picture;
  }
};

TEST_F(RemotePeer, a_view_at_rest_is_drawn_again_and_does_not_stop_the_training) {
  with_trainer("viewer_first", {}, [](const TcpAddress& address) {
    RemoteTraining training(
        address, [] {}, short_times());
    training.show(view_of(7));
    int last = 0;
    for (int i = 0; i < 4; ++i) {
      const auto picture = next_picture(training);
      ASSERT_TRUE(picture);
      EXPECT_EQ(picture->version, 7);
      EXPECT_EQ(picture->rgba.size(), 32u * 24 * 4);
      EXPECT_EQ(picture->rgba[3], 255);
      EXPECT_GT(iteration_of(*picture), last);
      last = iteration_of(*picture);
    }
    const RemoteRun run = training.run();
    EXPECT_TRUE(run.is_answering);
    EXPECT_FALSE(run.speaks_first);
    EXPECT_EQ(run.source, "/data/garden");
    EXPECT_EQ(run.problem, "");
  });
  EXPECT_GT(log_.at("iteration"), log_.at("requests"));
  EXPECT_GE(log_.at("accepted"), 4);
  EXPECT_EQ(log_.at("broken"), 0);
}

TEST_F(RemotePeer, requests_follow_each_other_while_the_user_moves) {
  with_trainer("viewer_first", {}, [](const TcpAddress& address) {
    RemoteTimes times = short_times();
    times.visit = 1h;
    RemoteTraining training(
        address, [] {}, times);
    RemoteView view = view_of(0);
    view.is_moving = true;
    for (view.version = 1; view.version < 20; ++view.version) {
      training.show(view);
      EXPECT_TRUE(until([&] {
        const auto picture = training.take_picture();
        return picture && picture->version == view.version;
      }));
    }
    view.is_moving = false;
    training.show(view);
    EXPECT_TRUE(until([&] {
      const auto picture = training.take_picture();
      return picture && picture->version == view.version;
    }));
  });
  EXPECT_EQ(log_.at("accepted"), 1);
  EXPECT_GE(log_.at("requests"), 20);
}

TEST_F(RemotePeer, a_trainer_that_speaks_first_gives_its_numbers_too) {
  with_trainer("trainer_first", {}, [](const TcpAddress& address) {
    RemoteTraining training(
        address, [] {}, short_times());
    training.show(view_of(1));
    for (int i = 0; i < 3; ++i) {
      const auto picture = next_picture(training);
      ASSERT_TRUE(picture);
      EXPECT_GT(iteration_of(*picture), 0);
    }
    const RemoteRun run = training.run();
    EXPECT_TRUE(run.speaks_first);
    EXPECT_EQ(run.source, "/data/garden");
    EXPECT_EQ(run.metrics.gaussians, 1234);
    EXPECT_EQ(run.metrics.loss, 0.25);
  });
  EXPECT_EQ(log_.at("broken"), 0);
}

TEST_F(RemotePeer, a_trainer_may_speak_first_late) {
  with_trainer("trainer_first", {"1000000", "0.5"}, [](const TcpAddress& address) {
    RemoteTimes times = short_times();
    times.first_word = 1ms;
    RemoteTraining training(
        address, [] {}, times);
    training.show(view_of(1));
    const auto picture = next_picture(training);
    ASSERT_TRUE(picture);
    EXPECT_TRUE(std::equal(picture->rgba.begin() + 4, picture->rgba.end(), picture->rgba.begin()))
        << "the picture has one colour";
    EXPECT_TRUE(training.run().speaks_first);
    EXPECT_EQ(training.run().metrics.loss, 0.25);
  });
}

TEST_F(RemotePeer, a_paused_training_stands_still_until_it_is_resumed) {
  with_trainer("viewer_first", {}, [](const TcpAddress& address) {
    RemoteTraining training(
        address, [] {}, short_times());
    training.show(view_of(1));
    ASSERT_TRUE(next_picture(training));
    training.pause(true);
    // The picture in progress may be of before.
    int at = 0;
    EXPECT_TRUE(until([&] {
      const auto picture = training.take_picture();
      const bool same = picture && iteration_of(*picture) == at;
      if (picture) at = iteration_of(*picture);
      return same;
    }));
    for (int i = 0; i < 20; ++i) {
      const auto picture = next_picture(training);
      ASSERT_TRUE(picture);
      EXPECT_EQ(iteration_of(*picture), at);
    }
    EXPECT_TRUE(training.run().paused);
    training.pause(false);
    EXPECT_TRUE(until([&] {
      const auto picture = training.take_picture();
      return picture && iteration_of(*picture) > at;
    }));
  });
}

TEST_F(RemotePeer, a_training_that_ends_is_named_and_is_not_held) {
  with_trainer("viewer_first", {"300"}, [&](const TcpAddress& address) {
    RemoteTraining training(
        address, [] {}, short_times());
    training.show(view_of(1));
    ASSERT_TRUE(next_picture(training));
    EXPECT_TRUE(until([&] { return !training.run().problem.empty(); }));
    EXPECT_FALSE(training.run().is_answering);
    EXPECT_THAT(training.run().problem, HasSubstr("the training"));
    EXPECT_TRUE(until([&] { return std::filesystem::exists(folder_ / "log"); }));
  });
  EXPECT_GE(log_.at("iteration"), 300);
}

TEST_F(RemotePeer, another_viewer_is_named_until_it_leaves) {
  with_trainer("viewer_first", {}, [](const TcpAddress& address) {
    int problem = 0;
    TcpSocket other = connect(address, patience(60s), problem);
    const std::string request = sibr_message(request_for(view_of(1).camera));
    ASSERT_EQ(other.write(std::as_bytes(std::span(request)), patience(60s)), TcpEnd::done);
    ASSERT_EQ(other.await_bytes(patience(60s)), TcpEnd::done);
    RemoteTraining training(
        address, [] {}, short_times());
    training.show(view_of(1));
    EXPECT_TRUE(until([&] { return !training.run().problem.empty(); }));
    EXPECT_THAT(training.run().problem, HasSubstr("another viewer is connected"));
    other.close();
    EXPECT_TRUE(next_picture(training));
    EXPECT_EQ(training.run().problem, "");
  });
}

// ---- without a trainer --------------------------------------------------------------------------
std::string problem_at(const TcpAddress& address) {
  RemoteTraining training(
      address, [] {}, short_times());
  training.show(view_of(1));
  EXPECT_TRUE(until([&] { return !training.run().problem.empty(); }));
  return training.run().problem;
}

TEST(RemoteTraining, a_training_that_does_not_answer_is_named) {
  const int free_port = listen_on_loopback(0, "test").port();
  EXPECT_THAT(problem_at(address_at(free_port)),
              HasSubstr("the training does not answer: Connection refused"));
}

TEST(RemoteTraining, a_program_that_is_no_trainer_is_named) {
  TcpSocket listener = listen_on_loopback(0, "test");
  const std::jthread program([&](const std::stop_token& stop) {
    TcpSocket socket = listener.accept(patience(120s, stop));
    const std::string nonsense(32 * 24 * 3 + 4, '\xff');
    socket.write(std::as_bytes(std::span(nonsense)), patience(120s, stop));
    socket.await_bytes(patience(120s, stop));
  });
  EXPECT_THAT(problem_at(address_at(listener.port())), HasSubstr("the answer is not a training's"));
}

TEST(RemoteTraining, a_connection_that_is_closed_is_named) {
  TcpSocket listener = listen_on_loopback(0, "test");
  const std::jthread program(
      [&](const std::stop_token& stop) { listener.accept(patience(120s, stop)); });
  EXPECT_THAT(problem_at(address_at(listener.port())),
              HasSubstr("the training has closed the connection"));
}

TEST(RemoteTraining, it_ends_while_it_waits_and_before_it_is_asked) {
  TcpSocket listener = listen_on_loopback(0, "test");
  {
    RemoteTraining unused(address_at(listener.port()), [] {});
  }
  RemoteTraining training(address_at(listener.port()), [] {});
  training.show(view_of(1));
  TcpSocket socket = listener.accept(patience(120s));
  EXPECT_TRUE(socket.is_open());
}

TEST(RemoteTraining, addresses_are_a_host_and_a_port) {
  EXPECT_NO_THROW(resolve("localhost:6009", "view: --connect"));
  EXPECT_NO_THROW(resolve("[::1]:6009", "view: --connect"));
  for (const char* text : {"localhost", ":6009", "localhost:", "localhost:0", "localhost:65536",
                           "localhost:6009x", "::1:6009", ""}) {
    EXPECT_THAT(test::error_of([&] { resolve(text, "view: --connect"); }, ErrorKind::usage),
                HasSubstr("not a host and a port such as localhost:6009"))
        << text;
  }
  EXPECT_THAT(test::error_of([] { resolve("no host:6009", "view: --connect"); }, ErrorKind::usage),
              HasSubstr("view: --connect no host:6009: "));
}

}  // namespace
}  // namespace qs
