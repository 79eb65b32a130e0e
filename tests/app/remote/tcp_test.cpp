// SPDX-License-Identifier: MIT
#include "app/remote/tcp.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

namespace qs {
namespace {

using namespace std::chrono_literals;

// The process may open no more files as long as this object exists.
class NoMoreFiles {
 public:
  NoMoreFiles() {
    getrlimit(RLIMIT_NOFILE, &before_);
    const int next = ::dup(0);
    ::close(next);
    const rlimit now{static_cast<rlim_t>(next), before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &now);
  }
  ~NoMoreFiles() { setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

TEST(Tcp, a_connection_that_cannot_be_accepted_waits_without_occupying_a_core) {
  TcpSocket listener = listen_on_loopback(0, "test");
  int problem = 0;
  const TcpSocket client = connect(resolve("127.0.0.1:" + std::to_string(listener.port()), "test"),
                                   patience(10s), problem);
  ASSERT_TRUE(client.is_open());
  {
    const NoMoreFiles no_more;
    const auto began = std::chrono::steady_clock::now();
    EXPECT_FALSE(listener.accept(patience(200ms)).is_open());
    EXPECT_GE(std::chrono::steady_clock::now() - began, 200ms);
  }
  EXPECT_TRUE(listener.accept(patience(10s)).is_open());
}

}  // namespace
}  // namespace qs
