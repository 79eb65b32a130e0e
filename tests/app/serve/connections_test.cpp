// SPDX-License-Identifier: MIT
//
// Counting of connections and addresses as functions of time.
#include "app/serve/connections.h"

#include <gtest/gtest.h>

namespace qs {
namespace {

using namespace std::chrono_literals;

class ServeConnections : public testing::Test {
 protected:
  ServeLimits limits_;
  Connections all_{limits_};
  Connections::Time now_{};
};

TEST_F(ServeConnections, an_address_is_forgotten_a_minute_after_its_wrong_token) {
  for (int i = 0; i < 1000; ++i) {
    const std::string address = "2001:db8::" + std::to_string(i);
    const auto place = all_.enter(address);
    all_.note_wrong_token(address, now_);
  }
  all_.prune(now_ + 59s);
  EXPECT_EQ(all_.addresses(), 1000u);
  all_.prune(now_ + 61s);
  EXPECT_EQ(all_.addresses(), 0u);
}

TEST_F(ServeConnections, an_address_with_a_connection_is_remembered) {
  auto place = all_.enter("a");
  all_.prune(now_);
  EXPECT_EQ(all_.addresses(), 1u);
  place.reset();
  all_.prune(now_);
  EXPECT_EQ(all_.addresses(), 0u);
}

TEST_F(ServeConnections, wrong_tokens_count_for_a_minute_and_for_their_address) {
  limits_.wrong_tokens_per_minute = 2;
  all_.note_wrong_token("a", now_);
  EXPECT_FALSE(all_.has_too_many_wrong_tokens("a", now_));
  all_.note_wrong_token("a", now_ + 30s);
  EXPECT_TRUE(all_.has_too_many_wrong_tokens("a", now_ + 30s));
  EXPECT_FALSE(all_.has_too_many_wrong_tokens("b", now_ + 30s));
  EXPECT_FALSE(all_.has_too_many_wrong_tokens("a", now_ + 61s));
}

TEST_F(ServeConnections, kinds_are_counted_apart) {
  limits_.requests = {2, 1};
  limits_.visitors = {2, 1};
  const auto first = all_.enter("a");
  ASSERT_TRUE(first->move_to(ConnectionKind::visitor));
  const auto second = all_.enter("a");
  EXPECT_EQ(second->kind(), ConnectionKind::request) << "a visitor takes no place of a request";
  EXPECT_FALSE(second->move_to(ConnectionKind::visitor)) << "one of this address";
  EXPECT_EQ(second->kind(), ConnectionKind::request);
  EXPECT_TRUE(all_.enter("b")->move_to(ConnectionKind::visitor));
  const auto refused = all_.enter("a");
  EXPECT_EQ(refused->kind(), ConnectionKind::leaving);
}

TEST_F(ServeConnections, refusals_are_counted_too) {
  limits_.requests = {0, 0};
  limits_.leaving = {2, 2};
  auto first = all_.enter("a");
  const auto second = all_.enter("b");
  EXPECT_FALSE(all_.enter("c"));
  first.reset();
  EXPECT_TRUE(all_.enter("c"));
}

}  // namespace
}  // namespace qs
