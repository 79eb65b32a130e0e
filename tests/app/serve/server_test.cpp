// SPDX-License-Identifier: MIT
// Needs QUADSPLAT_SERVE.
// Compiled alone: Boost takes long to compile.
//
// The server as clients meet it, each line of its rules: sound visitors, and those who are refused.
#include "app/serve/server.h"

#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>
#include <utility>  // Asio 1.74 uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/tcp.h>
#include <nlohmann/json.hpp>

#include "app/serve/message.h"
#include "app/serve/picture_message.h"
#include "app/serve/running_server.h"
#include "app/serve/served_training.h"
#include "app/support/run_program.h"
#include "io/picture/image_file.h"
#include "io/picture/webp_image.h"
#include "support/error_of.h"

namespace qs {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::system::error_code;
using Tcp = asio::ip::tcp;
using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using namespace std::chrono_literals;

using test::kToken;

class ServeServer : public testing::Test {
 protected:
  asio::io_context io_;
  test::RunningServer running_;
  ServeOptions& options_ = running_.options;

  std::string host() { return running_.host(); }

  static TcpSocket connect_to(int port, int& problem) {
    return qs::connect(resolve("127.0.0.1:" + std::to_string(port), "test"), patience(60s),
                       problem);
  }

  Tcp::socket connect() {
    Tcp::socket socket(io_);
    socket.connect({asio::ip::make_address("127.0.0.1"), running_.port()});
    return socket;
  }

  // Sends the bytes and reads until the server closes the connection.
  std::string answer_to(const std::string& bytes) {
    Tcp::socket socket = connect();
    return answer_on(socket, bytes);
  }
  static std::string answer_on(Tcp::socket& socket, const std::string& bytes) {
    error_code error;
    asio::write(socket, asio::buffer(bytes), error);
    std::string answer;
    asio::read(socket, asio::dynamic_buffer(answer), error);
    return answer;
  }
  std::string get(const std::string& target, const std::string& more = "") {
    return "GET " + target + " HTTP/1.1\r\nHost: " + host() + "\r\n" + more + "\r\n";
  }
  int status_of(const std::string& bytes) {
    const std::string answer = answer_to(bytes);
    return answer.size() > 12 ? std::stoi(answer.substr(9, 3)) : 0;
  }
};

// ---- HTTP ---------------------------------------------------------------------------------------
TEST_F(ServeServer, the_page_comes_with_the_fields_that_protect_it) {
  const std::string answer = answer_to(get("/"));
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("Content-Security-Policy: default-src 'none'; script-src 'self'"));
  EXPECT_THAT(answer, HasSubstr("X-Content-Type-Options: nosniff"));
  EXPECT_THAT(answer, HasSubstr("Cache-Control: no-store"));
  EXPECT_THAT(answer, HasSubstr("<canvas"));
  EXPECT_THAT(answer, Not(HasSubstr("https://"))) << "no resource of another site";
  EXPECT_THAT(answer_to(get("/page.js")), HasSubstr("text/javascript"));
}

TEST_F(ServeServer, requests_are_refused_by_the_rules) {
  EXPECT_EQ(status_of(get("/other")), 404);
  EXPECT_EQ(status_of(get("/../../../../etc/passwd")), 404);
  EXPECT_EQ(status_of(get("/live")), 404);
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n"), 405);
  EXPECT_EQ(status_of("NONSENSE / HTTP/1.1\r\nHost: localhost\r\n\r\n"), 405);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n"), 400);
  EXPECT_EQ(status_of("\x16\x03\x01 nonsense\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n"), 403);
  EXPECT_EQ(status_of(get("/" + std::string(1024, 'x'))), 414);
  EXPECT_EQ(status_of(get("/", "Filler: " + std::string(8192, 'x') + "\r\n")), 431);
  EXPECT_EQ(status_of(get("/", "Content-Length: 1\r\n") + "x"), 413);
  EXPECT_EQ(status_of(get("/", "Transfer-Encoding: chunked\r\n") + "0\r\n\r\n"), 413);
}

TEST_F(ServeServer, a_request_that_does_not_end_is_too_late) {
  options_.limits.head_time = 200ms;
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: localh"), 408);
}

TEST_F(ServeServer, connections_of_one_address_are_counted) {
  options_.limits.requests.per_address = 2;
  std::vector<Tcp::socket> open;
  open.push_back(connect());
  open.push_back(connect());
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"), 503);
  open.clear();
  int status = 0;  // the server notices the end soon
  for (int i = 0; i < 100 && status != 200; ++i) {
    std::this_thread::sleep_for(20ms);
    status = status_of("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  EXPECT_EQ(status, 200);
}

TEST_F(ServeServer, all_connections_are_counted) {
  options_.limits.requests.all = 1;
  const Tcp::socket open = connect();
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"), 503);
}

TEST_F(ServeServer, addresses_that_cannot_be_used_are_named) {
  ServeOptions taken = options_;
  taken.port = running_.port();
  EXPECT_THAT(test::error_of([&] { make_server(taken); }, ErrorKind::device),
              HasSubstr("cannot be used: Address already in use"));
  taken.address = "nowhere";
  EXPECT_THAT(test::error_of([&] { make_server(taken); }, ErrorKind::usage),
              HasSubstr("--address nowhere"));
}

TEST_F(ServeServer, an_answered_connection_does_not_count) {
  options_.limits.requests.per_address = 1;
  Tcp::socket first = connect();
  EXPECT_THAT(answer_on(first, get("/")), StartsWith("HTTP/1.1 200"));
  EXPECT_EQ(status_of(get("/")), 200) << "the first one is open";
}

TEST_F(ServeServer, the_files_of_tls_are_needed_at_the_start) {
  options_.tls = TlsFiles{"missing.pem", "missing.pem"};
  const std::string sentence = test::error_of([&] { make_server(options_); });
  EXPECT_TRUE(sentence == "serve: --certificate missing.pem: cannot be read: no such file" ||
              sentence.find("built without OpenSSL") != sentence.npos)
      << sentence;
}

// ---- WebSocket ----------------------------------------------------------------------------------
class ServeLive : public ServeServer {
 protected:
  using Socket = websocket::stream<Tcp::socket>;

  Socket open(const std::string& origin = "") { return handshaken(connect(), origin); }
  // On a socket with options of its own.
  Socket open_on(Tcp::socket bare) {
    bare.connect({asio::ip::make_address("127.0.0.1"), running_.port()});
    return handshaken(std::move(bare));
  }
  Socket handshaken(Tcp::socket bare, const std::string& origin = "") {
    Socket socket(std::move(bare));
    const std::string own = origin.empty() ? "http://" + host() : origin;
    socket.set_option(websocket::stream_base::decorator(
        [own](websocket::request_type& request) { request.set(beast::http::field::origin, own); }));
    socket.handshake(host(), "/live");
    return socket;
  }
  static void say(Socket& socket, const std::string& text) {
    socket.text(true);
    socket.write(asio::buffer(text));
  }
  static void greet(Socket& socket, const std::string& token = kToken,
                    const std::string& size = R"("width":64,"height":48)") {
    say(socket, R"({"type":"hello","token":")" + token + R"(",)" + size + "}");
  }
  // Reads until the server closes the connection; the code with which it does.
  static int code_at_end(Socket& socket) {
    error_code error;
    while (!error) {
      beast::flat_buffer buffer;
      socket.read(buffer, error);
    }
    return error == websocket::error::closed ? static_cast<int>(socket.reason().code) : 0;
  }

  struct Message {
    bool is_binary = false;
    std::string bytes;
    int flags() const { return static_cast<std::uint8_t>(bytes[2]); }
    std::uint32_t number(std::size_t place) const {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + place, sizeof(value));
      return value;
    }
  };
  Message read(Socket& socket) {
    beast::flat_buffer buffer;
    error_code error;
    socket.read(buffer, error);
    if (error) throw std::runtime_error("closed: " + std::string(socket.reason().reason.c_str()));
    all_ += beast::buffers_to_string(buffer.data());
    return {socket.got_binary(), beast::buffers_to_string(buffer.data())};
  }
  // Tries to visit until there is room, because another visitor has left.
  bool admits_another() {
    for (int i = 0; i < 1000; ++i) {
      std::this_thread::sleep_for(20ms);
      Socket socket = open();
      greet(socket);
      beast::flat_buffer buffer;
      error_code error;
      socket.read(buffer, error);
      if (!error) return true;
      if (socket.reason().code != websocket::close_code::try_again_later) return false;
    }
    return false;
  }
  // Confirms pictures as the page does, until an exact picture is complete; returns its file.
  std::string exact_picture(Socket& socket, std::uint32_t input = 0) {
    std::string file;
    while (true) {
      const Message message = read(socket);
      if (!message.is_binary) continue;
      ++received_;
      say(socket, R"({"type":"received","count":)" + std::to_string(received_) + "}");
      if (message.number(8) < input || (message.flags() & kLosslessFlag) == 0) {
        file.clear();
        continue;
      }
      file += message.bytes.substr(kPictureHeader);
      if ((message.flags() & kLastPartFlag) != 0) return file;
    }
  }

  std::string all_;  // the server has said
  std::uint32_t received_ = 0;
};

TEST_F(ServeLive, viewers_of_sibr_are_answered_beside_the_page) {
  options_.sibr.emplace().port = 0;
  Socket socket = open();
  greet(socket);
  int problem = 0;
  TcpSocket viewer = connect_to(running_.sibr_port(), problem);
  ASSERT_TRUE(viewer.is_open()) << problem;
  const std::string request =
      sibr_message(request_for(running_.small.opened[0]->facts.cameras.at(0)));
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(viewer.write(std::as_bytes(std::span(request)), patience(60s)), TcpEnd::done);
    std::vector<std::byte> answer(64 * 48 * 3 + 4);
    ASSERT_EQ(viewer.read(answer, patience(60s)), TcpEnd::done);
  }
  EXPECT_FALSE(exact_picture(socket).empty());
}

TEST_F(ServeLive, a_visitor_gets_state_and_exactly_the_picture_of_render) {
  Socket socket = open();
  greet(socket);
  const Message first = read(socket);
  EXPECT_FALSE(first.is_binary);
  const Json state = Json::parse(first.bytes);
  EXPECT_EQ(state.at("sections").at("scenes").size(), 2u);
  const std::string file = exact_picture(socket);
  const auto pixels = decode_webp(std::as_bytes(std::span(file)), "test");

  const auto folder = running_.small.folder.path();
  const auto run = test::run_quadsplat({"render", (folder / "secret0/scene0.ply").string(),
                                        "--backend", "cpu", "--camera-index", "0", "--size",
                                        "64x48", "--output", (folder / "out.png").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Image expected = read_image(folder / "out.png");
  ASSERT_EQ(pixels.size(), 4u * 64 * 48);
  for (std::size_t i = 0; i < 64 * 48; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_EQ(pixels[4 * i + c], to_8bit(expected.values[3 * i + c])) << i;
  }
  EXPECT_THAT(all_, Not(HasSubstr("secret"))) << "no path goes out";
  EXPECT_THAT(all_, Not(HasSubstr(folder.string())));
}

TEST_F(ServeLive, the_strips_of_an_exact_picture_are_the_picture_of_render) {
  constexpr int kWidth = 1000, kHeight = 600;
  Socket socket = open();
  greet(socket, kToken, R"("width":1000,"height":600)");
  std::string file;
  std::vector<std::uint8_t> pixels;
  for (bool is_complete = false; !is_complete;) {
    const Message message = read(socket);
    if (!message.is_binary) continue;
    say(socket, R"({"type":"received","count":)" + std::to_string(++received_) + "}");
    if ((message.flags() & kLosslessFlag) == 0) continue;
    file += message.bytes.substr(kPictureHeader);
    if ((message.flags() & kLastPartFlag) == 0) continue;
    const std::size_t top = message.number(20);
    EXPECT_EQ(pixels.size(), 4 * kWidth * top) << "strips come in order";
    const auto strip = decode_webp(std::as_bytes(std::span(file)), "test");
    EXPECT_EQ(webp_size(std::as_bytes(std::span(file)), "test").width, 1000u);
    pixels.insert(pixels.end(), strip.begin(), strip.end());
    file.clear();
    is_complete = (message.flags() & kLastStripFlag) != 0;
  }
  ASSERT_EQ(pixels.size(), 4u * kWidth * kHeight);

  const auto folder = running_.small.folder.path();
  const auto run = test::run_quadsplat({"render", (folder / "secret0/scene0.ply").string(),
                                        "--backend", "cpu", "--camera-index", "0", "--size",
                                        "1000x600", "--output", (folder / "out.ppm").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Image expected = read_image(folder / "out.ppm");
  for (std::size_t i = 0; i < kWidth * kHeight; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_EQ(pixels[4 * i + c], to_8bit(expected.values[3 * i + c])) << i;
  }
}

TEST_F(ServeLive, pictures_that_were_sent_are_counted_by_codec) {
  Socket socket = open();
  greet(socket);
  const std::string file = exact_picture(socket);
  const std::array<SentPictures, 4> sent = running_.sent();
  const SentPictures& exact = sent[static_cast<std::size_t>(PictureCodec::webp)];
  EXPECT_GE(exact.pictures, 1u);
  EXPECT_GE(exact.bytes, file.size());
  EXPECT_GT(exact.encode_ms, 0);
  EXPECT_GT(exact.send_ms, 0);
  EXPECT_EQ(sent[static_cast<std::size_t>(PictureCodec::vp9)].pictures, 0u);
}

TEST_F(ServeLive, pictures_answer_the_last_input_and_rest_after_it) {
  Socket socket = open();
  greet(socket);
  const std::string before = exact_picture(socket);
  say(socket, R"({"type":"wheel","notches":3,"input":1})");
  say(socket, R"({"type":"command","command":"Next camera","input":2})");
  EXPECT_NE(exact_picture(socket, 2), before);
}

TEST_F(ServeLive, a_file_comes_in_confirmed_parts_between_the_pictures) {
  Socket socket = open();
  greet(socket);
  for (int i = 0; i < 150; ++i) say(socket, R"({"type":"set","control":"Set here","value":0})");
  say(socket, R"({"type":"set","control":"Save","value":0})");
  std::string file, name;
  bool exact_came = false;  // before the end of the file
  for (bool is_complete = false; !is_complete;) {
    const Message message = read(socket);
    if (!message.is_binary) continue;
    say(socket, R"({"type":"received","count":)" + std::to_string(++received_) + "}");
    if (message.bytes[0] != 2) {
      exact_came = (message.flags() & kLosslessFlag) != 0 && (message.flags() & kLastPartFlag) != 0;
      continue;
    }
    const auto letters = static_cast<std::size_t>(message.number(0) >> 16);
    name = message.bytes.substr(16, letters);
    file += message.bytes.substr(16 + letters);
    is_complete = (message.bytes[1] & 4) != 0;
    EXPECT_GE(message.number(8), file.size());
  }
  EXPECT_EQ(name, "scene0_path.json");
  EXPECT_EQ(Json::parse(file).size(), 150u);
  EXPECT_GT(file.size(), 32768u) << "of several parts";
  EXPECT_THAT(all_, Not(HasSubstr("secret")));
  EXPECT_TRUE(exact_came || !exact_picture(socket).empty());
}

TEST_F(ServeLive, the_table_of_a_view_at_rest_is_measured) {
  Socket socket = open();
  greet(socket);
  say(socket, R"({"type":"command","command":"FPS of all modes","input":1})");
  std::string status;
  while (status.find("medians of") == status.npos) {
    const Message message = read(socket);
    if (message.is_binary) {
      say(socket, R"({"type":"received","count":)" + std::to_string(++received_) + "}");
      continue;
    }
    const Json sections = Json::parse(message.bytes).at("sections");
    if (sections.contains("table/text")) status = sections.at("table/text").at("text");
  }
  EXPECT_THAT(status, StartsWith("all modes measured off screen for this view at 64 x 48"));
}

TEST_F(ServeLive, visitors_of_one_address_leave_room_for_the_requests_of_a_page) {
  std::vector<Socket> visitors;
  for (int i = 0; i < 8; ++i) {
    visitors.push_back(open());
    greet(visitors.back());
    read(visitors.back());
  }
  std::vector<Tcp::socket> requests;  // as many as a browser has at once
  for (int i = 0; i < 6; ++i) requests.push_back(connect());
  for (Tcp::socket& request : requests)
    EXPECT_THAT(answer_on(request, get("/page.js")), StartsWith("HTTP/1.1 200"));
}

TEST_F(ServeLive, a_visitor_without_room_is_told_so) {
  options_.limits.visitors.all = 1;
  Socket first = open();
  greet(first);
  read(first);
  Socket second = open();
  greet(second);
  EXPECT_EQ(code_at_end(second), 1013);
}

TEST_F(ServeLive, pages_of_other_origins_are_refused) {
  for (const char* origin : {"null", "http://evil.example", "http://localhost"})
    EXPECT_THROW(open(origin), boost::system::system_error) << origin;
  const std::string upgrade =
      "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: "
      "13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
  EXPECT_EQ(status_of(get("/live", upgrade)), 403);
  EXPECT_EQ(status_of(get("/live", upgrade + "Origin: null\r\n")), 403);
}

TEST_F(ServeLive, a_token_is_needed_first_and_soon) {
  options_.limits.token_time = 200ms;
  Socket wrong = open();
  greet(wrong, "0123456789abcdef0123456789abcdee");
  EXPECT_EQ(code_at_end(wrong), 4401);
  Socket silent = open();
  EXPECT_EQ(code_at_end(silent), 4401);
  Socket hasty = open();
  say(hasty, R"({"type":"blur"})");
  EXPECT_EQ(code_at_end(hasty), 4401);
}

TEST_F(ServeLive, guessing_tokens_ends_soon) {
  options_.limits.wrong_tokens_per_minute = 3;
  for (int i = 0; i < 3; ++i) {
    Socket socket = open();
    greet(socket, "guess");
    EXPECT_EQ(code_at_end(socket), 4401);
  }
  try {
    open();
    ADD_FAILURE() << "a fourth guess was possible";
  } catch (const boost::system::system_error& error) {
    EXPECT_EQ(error.code(), websocket::error::upgrade_declined);
  }
}

TEST_F(ServeLive, damaged_messages_close_the_connection) {
  error_code ignored;
  const std::string spaces(65537, ' ');
  Socket early = open();
  early.write(asio::buffer(spaces), ignored);
  EXPECT_EQ(code_at_end(early), 1009);
  Socket long_one = open();  // a visitor may send a file
  greet(long_one);
  long_one.write(asio::buffer(spaces + std::string(2 * kMostFile, ' ')), ignored);
  EXPECT_EQ(code_at_end(long_one), 1009);
  Socket binary = open();
  binary.binary(true);
  binary.write(asio::buffer("x", 1));
  EXPECT_EQ(code_at_end(binary), 1003);
  Socket no_json = open();
  say(no_json, "hello");
  EXPECT_EQ(code_at_end(no_json), 1007);
  Socket liar = open();
  greet(liar);
  say(liar, R"({"type":"received","count":1000})");
  EXPECT_EQ(code_at_end(liar), 1008);
  Socket twice = open();
  greet(twice);
  greet(twice);
  EXPECT_EQ(code_at_end(twice), 1008);
}

TEST_F(ServeLive, too_many_messages_close_the_connection) {
  options_.limits.messages_per_second = 20;
  Socket socket = open();
  greet(socket);
  error_code error;
  for (int i = 0; i < 60 && !error; ++i)
    socket.write(asio::buffer(std::string(R"({"type":"blur"})")), error);
  EXPECT_EQ(code_at_end(socket), 1008);
}

TEST_F(ServeLive, silent_clients_are_dropped) {
  options_.limits.pong_time = 400ms;
  Socket socket = open();
  greet(socket);
  Tcp::socket& bare = socket.next_layer();
  std::string rest;  // read without answering pings
  error_code error;
  asio::read(bare, asio::dynamic_buffer(rest), error);
  EXPECT_EQ(error, asio::error::eof) << "the server closed the connection";
}

TEST_F(ServeLive, a_client_that_says_goodbye_and_stays_is_dropped) {
  options_.limits.write_time = 200ms;
  options_.limits.visitors.per_address = 1;
  Socket socket = open();
  greet(socket);
  const std::string goodbye = {'\x88', '\x80', 0, 0, 0, 0};
  asio::write(socket.next_layer(), asio::buffer(goodbye));
  EXPECT_TRUE(admits_another());
}

TEST_F(ServeLive, a_visitor_who_leaves_in_the_middle_harms_nobody) {
  for (int i = 0; i < 5; ++i) {
    Socket socket = open();
    greet(socket);
    if (i % 2 == 0) read(socket);
    const linger reset{1, 0};
    setsockopt(socket.next_layer().native_handle(), SOL_SOCKET, SO_LINGER, &reset, sizeof(reset));
  }
  Socket socket = open();
  greet(socket);
  EXPECT_FALSE(exact_picture(socket).empty());
}

TEST_F(ServeLive, a_storm_of_sizes_ends_with_the_last_one) {
  Socket socket = open();
  greet(socket);
  for (int i = 1; i <= 40; ++i) {
    say(socket, R"({"type":"resize","width":)" + std::to_string(1 + 37 * i % 300) +
                    R"(,"height":)" + std::to_string(i) + R"(,"input":)" + std::to_string(i) + "}");
  }
  const std::string file = exact_picture(socket, 40);
  const WebpSize size = webp_size(std::as_bytes(std::span(file)), "test");
  EXPECT_EQ(size.width, 281u);
  EXPECT_EQ(size.height, 40u);
}

TEST_F(ServeLive, twenty_visitors_are_all_served) {
  options_.limits.visitors.per_address = 40;
  std::vector<Socket> sockets;
  for (int i = 0; i < 20; ++i) {
    sockets.push_back(open());
    greet(sockets.back());
  }
  for (Socket& socket : sockets) {
    received_ = 0;
    EXPECT_FALSE(exact_picture(socket).empty());
  }
}

// A client that moves all the time: every picture is confirmed and answered by a new input.
class Mover : public std::enable_shared_from_this<Mover> {
 public:
  Mover(websocket::stream<Tcp::socket> socket, std::function<void()> on_picture)
      : socket_(std::move(socket)), on_picture_(std::move(on_picture)) {}

  void begin() {
    socket_.text(true);
    say(R"({"type":"hello","token":")" + std::string(kToken) + R"(","width":320,"height":240})");
    say(R"({"type":"video","decodes":true})");
    say(R"({"type":"button","button":0,"down":true,"x":0,"y":0,"input":1})");
    read();
  }
  void end() {
    has_ended_ = true;
    socket_.next_layer().close();
  }

  int pictures = 0;
  bool has_failed = false;

 private:
  void say(const std::string& text) { socket_.write(asio::buffer(text)); }
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (self->has_ended_) return;
      if (error) self->has_failed = true;
      if (!error) self->take();
    });
  }
  void take() {
    const bool is_picture = socket_.got_binary();
    buffer_.consume(buffer_.size());
    if (is_picture) {
      ++pictures;
      const std::string count = std::to_string(pictures), place = std::to_string(pictures % 90);
      say(R"({"type":"cursor","y":0,"x":)" + place + R"(,"input":)" + std::to_string(pictures + 1) +
          "}");
      say(R"({"type":"received","count":)" + count + "}");
      on_picture_();
    }
    read();
  }

  websocket::stream<Tcp::socket> socket_;
  beast::flat_buffer buffer_;
  std::function<void()> on_picture_;
  bool has_ended_ = false;
};

// Shares are of time, so other programs on the machine disturb the number of pictures.
// `scripts/check_serve load` counts more of them, within 20 %.
TEST_F(ServeLive, twenty_visitors_get_equal_shares) {
  constexpr int kVisitors = 20, kEach = 25, kWarm = 5;
  options_.limits.visitors.per_address = 40;
  options_.limits.messages_per_second = 100'000;
  running_.start();
  std::vector<std::shared_ptr<Mover> > movers;
  std::vector<int> before;
  int all = 0;
  for (int i = 0; i < kVisitors; ++i) {
    movers.push_back(std::make_shared<Mover>(open(), [&] {
      ++all;
      if (all == kWarm * kVisitors) {
        for (const auto& mover : movers) before.push_back(mover->pictures);
      }
      if (all == (kWarm + kEach) * kVisitors) io_.stop();
    }));
  }
  for (const auto& mover : movers) mover->begin();
  io_.run_for(120s);
  ASSERT_GE(all, (kWarm + kEach) * kVisitors);
  for (int i = 0; i < kVisitors; ++i) {
    const auto& mover = movers[static_cast<std::size_t>(i)];
    EXPECT_FALSE(mover->has_failed);
    const int share = mover->pictures - before[static_cast<std::size_t>(i)];
    EXPECT_GT(share, kEach / 3) << i;
    EXPECT_LT(share, 2 * kEach) << i;
  }
  for (const auto& mover : movers) mover->end();
  io_.restart();
  io_.run_for(1s);  // their last handlers
}

TEST_F(ServeLive, video_begins_with_a_key_and_again_when_the_page_asks) {
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  Socket socket = open();
  greet(socket, kToken, R"("width":640,"height":480)");
  say(socket, R"({"type":"video","decodes":true})");
  exact_picture(socket);
  // Every confirmation comes late, as over a slow line.
  constexpr int kEach = 6;
  int videos = 0, keys_after_asking = 0;
  int keys_inside[2] = {};      // of continued video, before and after asking
  std::uint32_t last_size = 0;  // of the video that the next picture continues; 0: none
  for (std::uint32_t input = 1; videos < 2 * kEach && input < 1000; ++input) {
    say(socket, R"({"type":"wheel","notches":)" + std::string(input % 2 == 0 ? "-0.5" : "0.5") +
                    R"(,"input":)" + std::to_string(input) + "}");
    Message message;
    do {
      message = read(socket);
    } while (!message.is_binary);
    std::this_thread::sleep_for(30ms);
    ++received_;
    say(socket, R"({"type":"received","count":)" + std::to_string(received_) + "}");
    const auto codec = static_cast<PictureCodec>(message.bytes[1]);
    if (codec == PictureCodec::jpeg) last_size = 0;  // a slow machine sends other sizes and codecs
    if (codec != PictureCodec::vp9) continue;
    const bool is_key = (message.flags() & kKeyFlag) != 0;
    const bool continues = message.number(16) == last_size;
    EXPECT_TRUE(continues || is_key);
    if (continues && is_key) ++keys_inside[videos >= kEach];
    if (videos >= kEach && is_key) ++keys_after_asking;
    last_size = message.number(16);
    if (++videos == kEach) say(socket, R"({"type":"video","decodes":true})");
  }
  ASSERT_EQ(videos, 2 * kEach) << "the line is slow enough for video";
  EXPECT_EQ(keys_inside[0], 0);
  EXPECT_LE(keys_inside[1], 1);
  EXPECT_GE(keys_after_asking, 1);
}

TEST_F(ServeLive, a_client_that_does_not_read_is_dropped) {
  options_.limits.write_time = 300ms;
  options_.limits.pong_time = 100s;
  options_.limits.visitors.per_address = 1;
  running_.start();
  // Small segments and a small buffer, so that the kernels hold less than a picture.
  Tcp::socket bare(io_, Tcp::v4());
  const int segment = 536;
  ASSERT_EQ(setsockopt(bare.native_handle(), IPPROTO_TCP, TCP_MAXSEG, &segment, sizeof(segment)),
            0);
  bare.set_option(asio::socket_base::receive_buffer_size(4096));
  Socket socket = open_on(std::move(bare));
  greet(socket, kToken, R"("width":4096,"height":4096)");
  EXPECT_TRUE(admits_another());
}

TEST_F(ServeLive, a_socket_killed_in_the_middle_of_a_picture_harms_nobody) {
  Socket other = open();
  greet(other);
  std::string before = exact_picture(other);
  for (int i = 0; i < 10; ++i) {
    Tcp::socket bare(io_, Tcp::v4());
    bare.set_option(asio::socket_base::receive_buffer_size(4096));
    Socket socket = open_on(std::move(bare));
    greet(socket, kToken, R"("width":2048,"height":1024)");
    // Read to the header of a picture, and no further.
    std::string some(200, ' ');
    error_code error;
    while (!socket.got_binary() && !error) socket.read_some(asio::buffer(some), error);
    ASSERT_FALSE(error) << error;
    const linger reset{1, 0};
    setsockopt(socket.next_layer().native_handle(), SOL_SOCKET, SO_LINGER, &reset, sizeof(reset));
    socket.next_layer().close();
    say(other, fmt::format(R"({{"type":"wheel","notches":1,"input":{}}})", i + 1));
    const std::string after = exact_picture(other, i + 1);
    EXPECT_NE(after, before);
    before = after;
  }
}

TEST_F(ServeLive, the_server_ends_with_visitors) {
  Socket socket = open();
  greet(socket);
  const auto began = std::chrono::steady_clock::now();
  running_.end();
  EXPECT_LT(std::chrono::steady_clock::now() - began, 5s);
}

TEST_F(ServeLive, an_exception_of_a_handler_does_not_end_the_server) {
  const auto server = make_server(options_);
  std::atomic<bool> ends = false;
  std::atomic<int> asked = 0;
  std::thread network([&] {
    const auto ends_later = [&] {
      if (++asked == 1) throw std::bad_alloc();
      return ends.load();
    };
    server->run(running_.small.scenes, ends_later, nullptr);
  });
  for (int i = 0; i < 500 && asked < 2; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_GE(asked, 2);
  ends = true;
  network.join();
}

// While the modes are measured, each picture makes the visitor's own handler throw.
class ThrowingRenderer : public Renderer {
 public:
  explicit ThrowingRenderer(RenderContext& context)
      : context_(context), inner_(std::move(context.session.renderer)) {}

  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override {
    inner_->upload(std::move(cloud), progress);
  }
  const Frame& render(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) override {
    if (context_.measuring) context_.report([](Viewer&) { throw std::bad_alloc(); });
    return inner_->render(camera, settings, outputs, target, stop);
  }

 private:
  RenderContext& context_;
  std::unique_ptr<Renderer> inner_;
};

TEST_F(ServeLive, an_exception_of_a_visitors_handler_ends_that_visitor_alone) {
  RenderContext& context = running_.small.scenes.front()->context;
  context.session.renderer = std::make_unique<ThrowingRenderer>(context);
  Socket other = open();
  greet(other);
  EXPECT_NE(exact_picture(other), "");
  received_ = 0;
  Socket socket = open();
  greet(socket);
  EXPECT_NE(exact_picture(socket), "");
  say(socket, R"({"type":"command","command":"FPS of all modes"})");
  EXPECT_EQ(code_at_end(socket), 1011);
  say(other, R"({"type":"resize","width":32,"height":24})");
  EXPECT_NE(read(other).bytes, "") << "the others are still served";
  EXPECT_TRUE(admits_another());
}

// ---- the program --------------------------------------------------------------------------------
int free_port() {
  asio::io_context io;
  return Tcp::acceptor(io, {asio::ip::make_address("127.0.0.1"), 0}).local_endpoint().port();
}

// Waits until the page is served.
void await_page(int port) {
  asio::io_context io;
  for (int i = 0; i < 600; ++i) {
    Tcp::socket socket(io);
    error_code error;
    socket.connect({asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(port)}, error);
    std::string answer;
    if (!error)
      asio::write(socket, asio::buffer("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n", 35), error);
    if (!error) asio::read(socket, asio::dynamic_buffer(answer), error);
    if (answer.starts_with("HTTP/1.1 200")) return;
    std::this_thread::sleep_for(50ms);
  }
  ADD_FAILURE() << "the page was not served";
}

TEST(ServeProgram, prints_its_address_and_ends_with_a_signal) {
  const test::SmallScenes scenes(1);
  const auto path = scenes.folder / "secret0/scene0.ply";
  const int port = free_port();
  std::chrono::steady_clock::time_point signalled;
  const auto run = test::run_quadsplat(
      {"serve", path.string(), "--backend", "cpu", "--port", std::to_string(port)},
      [&](pid_t process) {
        await_page(port);
        signalled = std::chrono::steady_clock::now();
        kill(process, SIGINT);
      });
  EXPECT_LT(std::chrono::steady_clock::now() - signalled, 2s);
  EXPECT_EQ(run.exit_code, 130) << run.err;
  EXPECT_THAT(run.out,
              testing::MatchesRegex("http://127\\.0\\.0\\.1:[0-9]+/#token=[0-9a-f]{32}\n"));
  EXPECT_THAT(run.err, HasSubstr("ssh -L "));
}

// ---- a training ---------------------------------------------------------------------------------
class ServeTraining : public ServeLive {
 protected:
  const std::filesystem::path model_ = running_.small.folder / "secret0";  // has cameras
  std::atomic<int> saved_ = 0;
  std::atomic<bool> finishes_ = false;
  // Outlives the server.
  std::unique_ptr<TrainingThread> trainer_ = std::make_unique<TrainingThread>(
      [] {}, [this](TrainingThread& thread) { return train(thread); });
  ServedTraining training_{*trainer_};
  ServedScenes scenes_;
  Json panels_;  // the last section of this name

  ~ServeTraining() override {
    finishes_ = true;
    trainer_->command(TrainingCommand::stop);
    running_.end();
  }

  // A run without an end, whose model has as many Gaussians as iterations.
  std::string train(TrainingThread& thread) {
    thread.began(model_, model_.parent_path() / "data", nullptr);
    for (int i = 0; !finishes_; ++i) {
      TrainingProgress progress;
      progress.iteration = i;
      progress.iterations = 1'000'000;
      progress.loss = 0.25;
      progress.gaussians = static_cast<std::uint64_t>(i) + 1;
      const TrainingCommand wish = thread.after_iteration(
          progress, [&] { return test::random_cloud(static_cast<std::size_t>(i) + 1, 0, 1); });
      if (wish == TrainingCommand::save) ++saved_;
      if (wish == TrainingCommand::stop) break;
      std::this_thread::sleep_for(1ms);
    }
    return "saved in " + model_.string();
  }

  void serve() {
    PageFacts page;
    page.threads = 1;
    scenes_.push_back(training_.open(page, [] { return false; }));
    ASSERT_TRUE(scenes_.back());
    running_.start(scenes_, &training_);
  }

  // Reads until a state of the panel for which the condition holds.
  template <class Holds>
  Json panel_when(Socket& socket, Holds holds) {
    while (true) {
      const Message message = read(socket);
      if (message.is_binary) {
        ++received_;
        say(socket, R"({"type":"received","count":)" + std::to_string(received_) + "}");
        continue;
      }
      const Json sections = Json::parse(message.bytes).at("sections");
      if (!sections.contains("training/facts")) continue;
      Json facts = Json::object();
      for (const Json& fact : sections["training/facts"]["facts"])
        facts[fact[0].get<std::string>()] = fact[1];
      if (holds(facts)) return facts;
    }
  }
  static void press(Socket& socket, const std::string& button) {
    say(socket, R"({"type":"set","value":1,"control":")" + button + "\"}");
  }
};

TEST_F(ServeTraining, visitors_see_pause_step_and_save_the_run) {
  serve();
  Socket socket = open();
  greet(socket);
  const auto is_later = [](const Json& facts) {
    return facts["state"] == "running" && facts["in the picture"] != "iteration 0";
  };
  const Json running = panel_when(socket, is_later);
  EXPECT_EQ(running["loss"], "0.2500");
  EXPECT_FALSE(running.contains("model"));
  press(socket, "Pause training");
  const Json paused =
      panel_when(socket, [](const Json& facts) { return facts["state"] == "paused"; });
  const auto shows_newest = [](const Json& facts) {
    return facts["iteration"].get<std::string>().starts_with(
        facts["in the picture"].get<std::string>().substr(10) + " of");
  };
  const Json shown = shows_newest(paused) ? paused : panel_when(socket, shows_newest);
  say(socket, R"({"type":"command","command":"exact","input":5})");
  EXPECT_FALSE(exact_picture(socket, 5).empty());
  press(socket, "Step");
  const Json stepped = panel_when(
      socket, [&](const Json& facts) { return facts["iteration"] != shown["iteration"]; });
  EXPECT_EQ(stepped["state"], "paused");
  press(socket, "Save the model");
  press(socket, "Pause training");
  panel_when(socket, [](const Json& facts) { return facts["state"] == "running"; });
  EXPECT_EQ(saved_, 1);
  finishes_ = true;
  const Json ended =
      panel_when(socket, [](const Json& facts) { return facts["state"] != "running"; });
  EXPECT_EQ(ended["state"], "saved in secret0");
  running_.end();
  EXPECT_THAT(all_, Not(HasSubstr(running_.small.folder.path().string())));
}

TEST_F(ServeTraining, a_reload_keeps_the_panel_as_it_was) {
  serve();
  const auto reloads_with = [&](const std::string& open_panels) {
    Socket socket = open();
    greet(socket);
    say(socket, R"({"type":"panels","open":[)" + open_panels + R"(],"input":9})");
    while (true) {  // a picture that answers the message, and the state before it
      const Message message = read(socket);
      if (message.is_binary)
        say(socket, R"({"type":"received","count":)" + std::to_string(++received_) + "}");
      if (!message.is_binary) {
        const Json sections = Json::parse(message.bytes).at("sections");
        if (sections.contains("panels")) panels_ = sections.at("panels");
        continue;
      }
      if (message.number(8) == 9) break;
    }
    received_ = 0;
    for (const Json& panel : panels_)
      if (panel.at("title") == "Training") return panel.at("open").get<bool>();
    return false;
  };
  EXPECT_TRUE(reloads_with(R"("Training")"));
  EXPECT_TRUE(reloads_with(R"("Training")")) << "also the second time";
  EXPECT_FALSE(reloads_with(""));
  finishes_ = true;
}

TEST_F(ServeTraining, a_page_that_dies_does_not_stop_the_run) {
  std::string sentence;
  int turns = 0;
  training_.outlive([] { throw std::bad_alloc(); },
                    [&](const std::string& told) { sentence = told; },
                    [&] { finishes_ = ++turns > 3; });
  EXPECT_THAT(sentence, StartsWith("the page has ended, and the training goes on without it"));
  EXPECT_GT(turns, 3) << "until the run ended by itself";
}

TEST_F(ServeTraining, visitors_cannot_stop_the_run) {
  VisitorHost host;
  EXPECT_THROW(host.train(TrainingCommand::stop), Error);
  host.train(TrainingCommand::pause);
  EXPECT_EQ(host.take_training_commands().size(), 1u);
  finishes_ = true;
}

}  // namespace
}  // namespace qs
