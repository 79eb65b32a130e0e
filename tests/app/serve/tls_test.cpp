// SPDX-License-Identifier: MIT
// Needs QUADSPLAT_TLS.
// Compiled alone: Boost takes long to compile.
//
// Encrypted connections: visitors, the limits, and the files of certificate and key.
#include <chrono>
#include <fstream>
#include <functional>
#include <thread>
#include <utility>  // Asio 1.74 uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/tcp.h>

#include "app/serve/certificate.h"
#include "app/serve/picture_message.h"
#include "app/serve/running_server.h"
#define QUADSPLAT_TLS  // this file is compiled only with it
#include "app/serve/tls_context.h"
#include "app/support/run_program.h"
#include "io/picture/webp_image.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace ssl = asio::ssl;
namespace websocket = beast::websocket;
using boost::system::error_code;
using Tcp = asio::ip::tcp;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;
using namespace std::chrono_literals;

constexpr const char* kGetPage = "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n";

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

class ServeTls : public testing::Test {
 protected:
  using Stream = beast::ssl_stream<Tcp::socket>;

  TemporaryFolder folder_;
  asio::io_context io_;
  ssl::context client_{ssl::context::tls_client};
  test::RunningServer running_;

  ServeTls() {
    const test::PrivateKey key = test::make_private_key();
    const std::string certificate = test::pem_of_certificate(key.get());
    write_text(folder_ / "certificate.pem", certificate);
    write_text(folder_ / "key.pem", test::pem_of_key(key.get()));
    running_.options.tls = TlsFiles{folder_ / "certificate.pem", folder_ / "key.pem"};
    client_.add_certificate_authority(asio::buffer(certificate));
    client_.set_verify_mode(ssl::verify_peer);
  }

  Tcp::socket connect() {
    Tcp::socket socket(io_);
    socket.connect({asio::ip::make_address("127.0.0.1"), running_.port()});
    return socket;
  }
  Stream encrypted(Tcp::socket socket) {
    Stream stream(std::move(socket), client_);
    stream.handshake(ssl::stream_base::client);
    return stream;
  }
  // Sends the bytes and reads until the server ends.
  template <class AnyStream>
  static std::string answer_on(AnyStream& stream, const std::string& bytes,
                               const error_code& expected) {
    error_code error;
    asio::write(stream, asio::buffer(bytes), error);
    std::string answer;
    asio::read(stream, asio::dynamic_buffer(answer), error);
    EXPECT_EQ(error, expected) << error.message();
    return answer;
  }
  std::string answer_to(const std::string& bytes) {
    Stream stream = encrypted(connect());
    return answer_on(stream, bytes, asio::error::eof);  // the server has said that nothing follows
  }
  // The status of the page, when it is another one than 503.
  int later_status() {
    int status = 503;
    for (int i = 0; i < 1000 && status == 503; ++i) {
      std::this_thread::sleep_for(20ms);
      status = std::stoi(answer_to(kGetPage).substr(9, 3));
    }
    return status;
  }

  using Socket = websocket::stream<Stream>;
  Socket open(const std::string& scheme = "https") { return open_on(connect(), scheme); }
  Socket open_on(Tcp::socket bare, const std::string& scheme = "https") {
    Socket socket(encrypted(std::move(bare)));
    const std::string origin = scheme + "://" + running_.host();
    socket.set_option(websocket::stream_base::decorator([origin](websocket::request_type& request) {
      request.set(beast::http::field::origin, origin);
    }));
    socket.handshake(running_.host(), "/live");
    return socket;
  }
  static void say(Socket& socket, const std::string& text) {
    socket.text(true);
    socket.write(asio::buffer(text));
  }
  static void greet(Socket& socket, const std::string& size = R"("width":64,"height":48)") {
    say(socket, R"({"type":"hello","token":")" + std::string(test::kToken) + R"(",)" + size + "}");
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
};

TEST_F(ServeTls, the_page_comes_encrypted) {
  const std::string answer = answer_to(kGetPage);
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("<canvas"));
  EXPECT_THAT(answer_to("GET /other HTTP/1.1\r\nHost: localhost\r\n\r\n"),
              StartsWith("HTTP/1.1 404"));
}

TEST_F(ServeTls, a_visitor_gets_an_exact_picture) {
  Socket socket = open();
  greet(socket);
  std::string file;
  for (int received = 0, flags = 0; (flags & kLosslessFlag) == 0 || (flags & kLastPartFlag) == 0;) {
    beast::flat_buffer buffer;
    socket.read(buffer);
    if (!socket.got_binary()) continue;
    const std::string bytes = beast::buffers_to_string(buffer.data());
    flags = static_cast<unsigned char>(bytes[2]);
    if ((flags & kLosslessFlag) != 0) file += bytes.substr(kPictureHeader);
    say(socket, R"({"type":"received","count":)" + std::to_string(++received) + "}");
  }
  EXPECT_EQ(decode_webp(std::as_bytes(std::span(file)), "test").size(), 4u * 64 * 48);
  socket.close(websocket::close_code::normal);
}

TEST_F(ServeTls, the_origin_is_the_encrypted_page) {
  EXPECT_THROW(open("http"), boost::system::system_error);
  EXPECT_NO_THROW(open());
}

TEST_F(ServeTls, http_gets_a_sentence_and_other_bytes_an_end) {
  Tcp::socket plain = connect();
  const std::string answer = answer_on(plain, kGetPage, asio::error::eof);
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(answer, HasSubstr("this port speaks https only"));
  for (const char* bytes : {"nonsense without end\r\n\r\n", "\x16\x03\x01\xff\xff nonsense"}) {
    Tcp::socket socket = connect();
    error_code error;
    asio::write(socket, asio::buffer(std::string(bytes)), error);
    socket.shutdown(Tcp::socket::shutdown_send, error);
    std::string rest;
    asio::read(socket, asio::dynamic_buffer(rest), error);
    EXPECT_THAT(rest, Not(HasSubstr("HTTP"))) << bytes;
  }
  EXPECT_THAT(answer_to(kGetPage), StartsWith("HTTP/1.1 200"));
}

TEST_F(ServeTls, versions_before_1_2_are_refused) {
  SSL_CTX_set_security_level(client_.native_handle(), 0);
  SSL_CTX_set_min_proto_version(client_.native_handle(), TLS1_VERSION);
  SSL_CTX_set_max_proto_version(client_.native_handle(), TLS1_1_VERSION);
  EXPECT_THROW(encrypted(connect()), boost::system::system_error);
  SSL_CTX_set_max_proto_version(client_.native_handle(), TLS1_2_VERSION);
  EXPECT_THAT(answer_to(kGetPage), StartsWith("HTTP/1.1 200"));
}

// ---- limits -------------------------------------------------------------------------------------
TEST_F(ServeTls, a_handshake_that_does_not_end_is_dropped) {
  running_.options.limits.head_time = 200ms;
  running_.options.limits.requests.per_address = 1;
  Tcp::socket silent = connect();
  std::string rest;
  error_code error;
  asio::write(silent, asio::buffer("\x16\x03\x01\x02", 4), error);  // a part of a first message
  asio::read(silent, asio::dynamic_buffer(rest), error);
  EXPECT_EQ(error, asio::error::eof) << error.message();
  EXPECT_EQ(rest, "");
  EXPECT_EQ(later_status(), 200);
}

TEST_F(ServeTls, a_request_that_does_not_end_is_too_late) {
  running_.options.limits.head_time = 1s;
  EXPECT_THAT(answer_to("GET / HTTP/1.1\r\nHost: localh"), StartsWith("HTTP/1.1 408"));
}

TEST_F(ServeTls, connections_are_counted_from_before_the_handshake) {
  running_.options.limits.requests.per_address = 1;
  {
    const Tcp::socket open = connect();
    EXPECT_THAT(answer_to(kGetPage), StartsWith("HTTP/1.1 503"));
  }
  EXPECT_EQ(later_status(), 200);
}

TEST_F(ServeTls, a_client_that_does_not_read_is_dropped) {
  running_.options.limits.write_time = 300ms;
  running_.options.limits.pong_time = 100s;
  running_.options.limits.visitors.per_address = 1;
  Tcp::socket bare(io_, Tcp::v4());
  const int segment = 536;
  ASSERT_EQ(setsockopt(bare.native_handle(), IPPROTO_TCP, TCP_MAXSEG, &segment, sizeof(segment)),
            0);
  bare.set_option(asio::socket_base::receive_buffer_size(4096));
  bare.connect({asio::ip::make_address("127.0.0.1"), running_.port()});
  Socket socket = open_on(std::move(bare));
  greet(socket, R"("width":4096,"height":4096)");
  EXPECT_TRUE(admits_another());
}

TEST_F(ServeTls, a_client_that_says_goodbye_and_stays_is_dropped) {
  running_.options.limits.write_time = 200ms;
  running_.options.limits.visitors.per_address = 1;
  Socket socket = open();
  greet(socket);
  const std::string goodbye = {'\x88', '\x80', 0, 0, 0, 0};
  asio::write(socket.next_layer(), asio::buffer(goodbye));
  EXPECT_TRUE(admits_another());
}

TEST_F(ServeTls, a_client_that_vanishes_harms_nobody) {
  for (int i = 0; i < 6; ++i) {
    Socket socket = open();
    greet(socket);
    const linger reset{1, 0};
    Tcp::socket& bare = socket.next_layer().next_layer();
    if (i % 2 == 0) setsockopt(bare.native_handle(), SOL_SOCKET, SO_LINGER, &reset, sizeof(reset));
    bare.close();
  }
  EXPECT_THAT(answer_to(kGetPage), StartsWith("HTTP/1.1 200"));
}

// ---- certificate and key ------------------------------------------------------------------------
class ServeTlsFiles : public testing::Test {
 protected:
  TemporaryFolder folder_;
  test::PrivateKey key_ = test::make_private_key();
  std::string certificate_ = test::pem_of_certificate(key_.get());
  std::string pem_ = test::pem_of_key(key_.get());

  // The sentence for these contents, "" if they serve.
  std::string sentence(const std::string& certificate, const std::string& key) {
    write_text(folder_ / "c.pem", certificate);
    write_text(folder_ / "k.pem", key);
    return sentence_of({folder_ / "c.pem", folder_ / "k.pem"});
  }
  std::string sentence_of(const TlsFiles& files) {
    ServeOptions options;
    options.port = 0;
    options.tls = files;
    return test::error_of([&] { make_server(options); }, folder_.path());
  }
};

TEST_F(ServeTlsFiles, sound_ones_serve) {
  EXPECT_EQ(sentence(certificate_, pem_), "");
  EXPECT_EQ(sentence(certificate_ + certificate_, pem_), "") << "a chain";
  EXPECT_EQ(sentence(pem_ + certificate_, certificate_ + pem_), "") << "both in a file";
}

TEST_F(ServeTlsFiles, missing_ones_are_named) {
  EXPECT_EQ(sentence_of({folder_ / "c.pem", folder_ / "k.pem"}),
            "serve: --certificate c.pem: cannot be read: no such file");
  write_text(folder_ / "c.pem", certificate_);
  EXPECT_EQ(sentence_of({folder_ / "c.pem", folder_ / "k.pem"}),
            "serve: --key k.pem: cannot be read: no such file");
  EXPECT_EQ(sentence_of({folder_ / "c.pem", folder_.path()}).substr(0, 12), "serve: --key");
}

TEST_F(ServeTlsFiles, damaged_ones_are_refused) {
  EXPECT_EQ(sentence("", pem_), "serve: --certificate c.pem: has no certificate in PEM format");
  EXPECT_EQ(sentence(pem_, pem_), "serve: --certificate c.pem: has no certificate in PEM format");
  EXPECT_EQ(sentence(certificate_, ""), "serve: --key k.pem: has no private key in PEM format");
  EXPECT_EQ(sentence(certificate_, certificate_),
            "serve: --key k.pem: has no private key in PEM format");
  for (const std::size_t place : {100u, 200u, 300u}) {
    std::string certificate = certificate_;
    certificate[place] = '!';
    EXPECT_THAT(sentence(certificate, pem_),
                StartsWith("serve: --certificate c.pem: OpenSSL refuses it: "));
    EXPECT_NE(sentence(certificate_.substr(0, place), pem_), "");
  }
  std::string key = pem_;
  key[60] = '!';
  EXPECT_THAT(sentence(certificate_, key), StartsWith("serve: --key k.pem: OpenSSL refuses it: "));
  EXPECT_NE(sentence(certificate_, pem_.substr(0, 80)), "");
  EXPECT_THAT(sentence(certificate_, std::string(2 << 20, 'x')), HasSubstr("k.pem: 2097152 bytes"));
}

TEST_F(ServeTlsFiles, a_key_of_another_certificate_is_refused) {
  const char* const expected = "serve: --key k.pem: is not the key of c.pem";
  const test::PrivateKey other = test::make_private_key();
  EXPECT_EQ(sentence(certificate_, test::pem_of_key(other.get())), expected);
  const test::PrivateKey rsa(EVP_RSA_gen(2048), &EVP_PKEY_free);
  EXPECT_EQ(sentence(certificate_, test::pem_of_key(rsa.get())), expected);
}

TEST_F(ServeTlsFiles, the_context_keeps_no_pointer_into_the_function_that_made_it) {
  write_text(folder_ / "c.pem", certificate_);
  write_text(folder_ / "k.pem", pem_);
  TlsContext context = make_tls_context({folder_ / "c.pem", folder_ / "k.pem"}, "test");
  EXPECT_EQ(SSL_CTX_get_default_passwd_cb_userdata(context.native_handle()), nullptr);
}

TEST_F(ServeTlsFiles, a_key_with_a_password_is_refused_without_a_question) {
  EXPECT_EQ(sentence(certificate_, test::pem_of_key(key_.get(), "secret")),
            "serve: --key k.pem: has a password; remove it: openssl pkey -in k.pem -out NEW.pem");
}

TEST_F(ServeTlsFiles, a_certificate_of_another_time_serves_with_a_warning) {
  write_text(folder_ / "k.pem", pem_);
  const auto warnings = [&](test::ValidTime valid) {
    write_text(folder_ / "c.pem", test::pem_of_certificate(key_.get(), valid));
    ServeOptions options;
    options.port = 0;
    options.tls = TlsFiles{folder_ / "c.pem", folder_ / "k.pem"};
    return make_server(options)->warnings();
  };
  constexpr long kDay = 86400;
  EXPECT_THAT(warnings({}), IsEmpty());
  EXPECT_THAT(
      warnings({-10 * kDay, -kDay}),
      ElementsAre(ContainsRegex("^serve: --certificate .*c.pem: has expired on "
                                "20[0-9][0-9]-[0-9][0-9]-[0-9][0-9]; browsers refuse it$")));
  EXPECT_THAT(warnings({kDay, 2 * kDay}), ElementsAre(HasSubstr("c.pem: is not valid before 20")));
}

// ---- the program --------------------------------------------------------------------------------
// A server without a scene ends after its warning.
TEST(ServeTlsProgram, only_lines_that_others_can_read_are_a_warning) {
  const TemporaryFolder folder;
  const test::PrivateKey key = test::make_private_key();
  write_text(folder / "both.pem",
             test::pem_of_certificate(key.get()) + test::pem_of_key(key.get()));
  const auto said = [&](const char* address, std::vector<std::string> more) {
    std::vector<std::string> words = {
        "serve", (folder / "missing.ply").string(), "--port", "0", "--address", address};
    words.insert(words.end(), more.begin(), more.end());
    const test::ProgramRun run = test::run_quadsplat(words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    return run.err;
  };
  const std::string both = (folder / "both.pem").string();
  EXPECT_THAT(said("0.0.0.0", {}), HasSubstr("not encrypted"));
  EXPECT_THAT(said("0.0.0.0", {"--certificate", both, "--key", both}),
              Not(HasSubstr("not encrypted")));
  EXPECT_THAT(said("127.0.0.2", {}), Not(HasSubstr("not encrypted"))) << "this machine's own";
}

TEST(ServeTlsProgram, an_expired_certificate_is_one_sentence_at_the_start) {
  const TemporaryFolder folder;
  const test::PrivateKey key = test::make_private_key();
  const std::string both = (folder / "both.pem").string();
  write_text(both,
             test::pem_of_certificate(key.get(), {-7200, -3600}) + test::pem_of_key(key.get()));
  const test::ProgramRun run =
      test::run_quadsplat({"serve", (folder / "missing.ply").string(), "--port", "0",
                           "--certificate", both, "--key", both});
  EXPECT_THAT(run.err, StartsWith("quadsplat: serve: --certificate " + both + ": has expired on "));
}

TEST(ServeTlsProgram, certificate_and_key_need_each_other) {
  const std::vector<std::vector<std::string>> commands = {
      {"serve", "scene.ply"}, {"train", "data", "--out-dir", "model", "--serve"}};
  for (std::vector<std::string> words : commands) {
    const std::string expected = words.front() + ": --certificate and --key need each other";
    for (const char* option : {"--certificate", "--key"}) {
      std::vector<std::string> all = words;
      all.insert(all.end(), {option, "file.pem"});
      const test::ProgramRun run = test::run_quadsplat(all);
      EXPECT_EQ(run.exit_code, 1);
      EXPECT_THAT(run.err, HasSubstr(expected));
    }
  }
}

}  // namespace
}  // namespace qs
