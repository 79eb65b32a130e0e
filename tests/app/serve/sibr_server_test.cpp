// SPDX-License-Identifier: MIT
//
// The server as INRIA's remote viewer meets it.
#include "app/serve/sibr_server.h"

#include <chrono>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/serve/serve_scenes.h"
#include "app/support/run_program.h"
#include "support/error_of.h"

namespace qs {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class ServeSibr : public testing::Test {
 protected:
  test::SmallScenes small_{1};
  SibrOptions options_;
  TcpSocket listener_;
  std::unique_ptr<Pictures> pictures_;
  std::unique_ptr<SibrServer> server_;

  ServeSibr() { options_.port = 0; }
  ~ServeSibr() override {
    server_.reset();
    pictures_.reset();
  }

  TcpSocket viewer() {
    if (!server_) {
      listener_ = listen_for_sibr(options_);
      pictures_ = std::make_unique<Pictures>(
          small_.scenes, Pictures::Receiver{[](int) {}, [](int, Picture) {}, [](int, Actions) {}});
      server_ = std::make_unique<SibrServer>(listener_, options_, *pictures_, *small_.opened[0]);
    }
    int problem = 0;
    TcpSocket socket = connect(resolve("127.0.0.1:" + std::to_string(listener_.port()), "test"),
                               patience(60s), problem);
    EXPECT_TRUE(socket.is_open()) << problem;
    return socket;
  }

  static void say(TcpSocket& socket, const std::string& bytes) {
    EXPECT_EQ(socket.write(std::as_bytes(std::span(bytes)), patience(60s)), TcpEnd::done);
  }
  // Unset if the server closes the connection before.
  static std::optional<std::string> hear(TcpSocket& socket, std::size_t count) {
    std::string bytes(count, '\0');
    const TcpEnd end = socket.read(std::as_writable_bytes(std::span(bytes)), patience(60s));
    EXPECT_NE(end, TcpEnd::late);
    return end == TcpEnd::done ? std::optional(bytes) : std::nullopt;
  }
  static bool is_closed(TcpSocket& socket) { return !hear(socket, 1); }

  Camera camera() const { return small_.opened[0]->facts.cameras.at(1); }
  std::string request() const { return sibr_message(request_for(camera())); }
};

// The tests' picture of 64 x 48 pixels.
constexpr std::size_t kBytes = 64 * 48 * 3;

TEST_F(ServeSibr, a_viewer_gets_the_pixels_of_render_and_then_the_name) {
  options_.name = "/data/garden";
  TcpSocket socket = viewer();
  for (int i = 0; i < 3; ++i) {
    say(socket, request());
    const auto rgb = hear(socket, kBytes);
    ASSERT_TRUE(rgb);
    EXPECT_EQ(hear(socket, 4), std::string("\x0c\0\0\0", 4));
    EXPECT_EQ(hear(socket, 12), "/data/garden");
    if (i > 0) continue;
    ThreadPool pool(1);
    const auto renderer = make_renderer(Backend::cpu, pool);
    const Session& session = small_.scenes[0]->context.session;
    renderer->upload(session.scene->cloud, {});
    const SibrRequest asked = *parse_sibr_request(request().substr(4));
    const Frame& frame = renderer->render(*camera_of(asked), session.settings, {}, HostImage{}, {});
    for (std::size_t pixel = 0; pixel < kBytes; ++pixel)
      ASSERT_EQ(static_cast<std::uint8_t>((*rgb)[pixel]), to_8bit(frame.color.values[pixel]));
  }
}

TEST_F(ServeSibr, a_side_of_zero_is_answered_without_a_picture) {
  TcpSocket socket = viewer();
  say(socket, with_length(R"({"resolution_x":0,"resolution_y":0,"fov_x":null})"));
  EXPECT_EQ(hear(socket, 4), std::string(4, '\0'));
  say(socket, request());
  EXPECT_TRUE(hear(socket, kBytes + 4)) << "the viewer goes on";
}

TEST_F(ServeSibr, a_view_of_nulls_shows_the_background) {
  TcpSocket socket = viewer();
  std::string json = request().substr(4);
  const std::size_t first = json.find("\"view_matrix\":[") + 15;
  json.replace(first, json.find(',', first) - first, "null");
  say(socket, with_length(json));
  EXPECT_EQ(hear(socket, kBytes), std::string(kBytes, '\0'));
  EXPECT_EQ(hear(socket, 4), std::string(4, '\0'));
}

TEST_F(ServeSibr, a_request_may_come_in_parts) {
  TcpSocket socket = viewer();
  const std::string bytes = request();
  for (const std::string& part : {bytes.substr(0, 2), bytes.substr(2, 300), bytes.substr(302)}) {
    say(socket, part);
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_TRUE(hear(socket, kBytes + 4));
}

TEST_F(ServeSibr, damaged_requests_close_the_viewer) {
  for (const std::string& bytes :
       {with_length("{\"resolution_x\":64,"), with_length(""), with_length("nonsense"),
        with_length(R"({"resolution_x":-1,"resolution_y":48})"),
        with_length(R"({"resolution_x":4097,"resolution_y":1})"),
        std::string("\x01\x20\0\0", 4),  // 8 KiB and a byte
        std::string("\xff\xff\xff\xff", 4)}) {
    TcpSocket socket = viewer();
    say(socket, bytes);
    EXPECT_TRUE(is_closed(socket)) << bytes;
  }
}

TEST_F(ServeSibr, json_of_8_kib_is_read) {
  TcpSocket socket = viewer();
  std::string json = request().substr(4);
  json += std::string(kMostSibrRequest - json.size(), ' ');
  say(socket, with_length(json));
  EXPECT_TRUE(hear(socket, kBytes + 4));
}

TEST_F(ServeSibr, silence_closes_the_viewer) {
  options_.silence = 100ms;
  TcpSocket silent = viewer(), slow = viewer();
  EXPECT_TRUE(is_closed(silent));
  say(slow, request().substr(0, 10));
  EXPECT_TRUE(is_closed(slow)) << "a request must be complete";
}

TEST_F(ServeSibr, a_viewer_more_than_four_is_closed) {
  std::vector<TcpSocket> sockets;
  for (int i = 0; i < 4; ++i) {
    sockets.push_back(viewer());
    say(sockets.back(), request());
    EXPECT_TRUE(hear(sockets.back(), kBytes + 4));
  }
  TcpSocket fifth = viewer();
  EXPECT_TRUE(is_closed(fifth));
  sockets.erase(sockets.begin());
  bool answered = false;  // the server notices the end soon
  for (int i = 0; i < 500 && !answered; ++i) {
    std::this_thread::sleep_for(20ms);
    TcpSocket next = viewer();
    const std::string bytes = request();
    next.write(std::as_bytes(std::span(bytes)), patience(60s));
    answered = hear(next, kBytes).has_value();
  }
  EXPECT_TRUE(answered);
}

TEST_F(ServeSibr, it_ends_while_viewers_are_silent_or_do_not_read) {
  TcpSocket silent = viewer(), deaf = viewer();
  for (TcpSocket* const socket : {&silent, &deaf}) {  // the server has accepted both
    say(*socket, request());
    EXPECT_TRUE(hear(*socket, kBytes + 4));
  }
  for (int i = 0; i < 200; ++i) say(deaf, request());
  server_.reset();
  EXPECT_TRUE(is_closed(silent));
}

TEST_F(ServeSibr, a_taken_port_is_named) {
  viewer();
  SibrOptions taken;
  taken.port = listener_.port();
  EXPECT_THAT(test::error_of([&] { listen_for_sibr(taken); }, ErrorKind::device),
              HasSubstr("serve: --sibr-port " + std::to_string(taken.port) +
                        ": 127.0.0.1 cannot be used: Address already in use"));
}

TEST(ServeSibrOptions, what_does_not_fit_is_refused) {
  const auto refusal = [](std::vector<std::string> words) {
    words.insert(words.begin(), {"serve", "scene.ply"});
    const auto run = test::run_quadsplat(words);
    EXPECT_EQ(run.exit_code, 1);
    return run.err;
  };
  EXPECT_THAT(refusal({"--sibr-port", "6010"}), HasSubstr("serve: --sibr-port: needs --sibr"));
  EXPECT_THAT(refusal({"--sibr-name", "/data"}), HasSubstr("serve: --sibr-name: needs --sibr"));
  EXPECT_THAT(refusal({"--sibr", "--address", "0.0.0.0"}),
              HasSubstr("serve: --address 0.0.0.0: --sibr asks nobody for a token"));
  EXPECT_THAT(refusal({"--sibr", "--sibr-name", "\xc3\xa9"}), HasSubstr("must be ASCII text"));
  EXPECT_THAT(refusal({"--sibr", "--sibr-name", std::string(1025, 'x')}),
              HasSubstr("at most 1024 letters"));
}

}  // namespace
}  // namespace qs
