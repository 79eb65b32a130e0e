// SPDX-License-Identifier: MIT
//
// The messages to one page as functions of time: no test waits.
#include "app/serve/visitor_link.h"

#include <cmath>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/serve/serve_scenes.h"

namespace qs {
namespace {

using testing::HasSubstr;
using Step = VisitorLink::Step;
using Taken = VisitorLink::Taken;

constexpr double kMaking = 0.01;  ///< seconds from the order of a picture to its bytes

Picture picture_of(const PictureOrder& order) {
  Picture picture;
  picture.order = order;
  picture.width = 64;
  picture.height = 48;
  picture.encoded.codec = order.lossless ? PictureCodec::webp : PictureCodec::jpeg;
  picture.encoded.bytes = std::string(1000, 'x');
  picture.encoded.ms = 2;
  picture.shown.version = order.request.version;
  return picture;
}

class ServeLink : public testing::Test {
 protected:
  test::SmallScenes small_{1};
  ServeLimits limits_;
  std::string token_ = "0123456789abcdef0123456789abcdef";
  std::array<SentPictures, 4> sent_{};
  double now_ = 100;
  VisitorLink link_{{limits_, token_, small_.opened, sent_}, now_};
  std::vector<VisitorLink::Message> messages_;
  std::deque<std::pair<double, PictureOrder>> in_work_;  // ready then
  int orders_ = 0, pings_ = 0;
  std::uint32_t input_ = 0, received_ = 0;
  int confirmed_before_ = 0;  // messages_ was cleared

  Taken say(const std::string& text) { return link_.take(text, false, now_); }
  Taken greet() {
    return say(R"({"type":"hello","width":64,"height":48,"token":")" + token_ + "\"}");
  }
  void turn_wheel() {
    say(R"({"type":"wheel","notches":1,"input":)" + std::to_string(++input_) + "}");
  }
  void confirm() {
    ++received_;
    EXPECT_EQ(say(R"({"type":"received","count":)" + std::to_string(received_) + "}"),
              Taken::message);
  }
  void confirm_all() {
    while (static_cast<int>(received_) < confirmed_before_ + count(false)) confirm();
  }
  Step advance(double seconds = 0) {
    now_ += seconds;
    return link_.advance(now_, [](Visitor& visitor) { visitor.host().take_jobs(); });
  }
  // Passes time. Messages leave at once, and pictures are ready after kMaking.
  void pass(double seconds) {
    const double end = now_ + seconds;
    while (true) {
      Step step = advance();
      if (step.order) {
        ++orders_;
        in_work_.emplace_back(now_ + kMaking, std::move(*step.order));
      }
      if (step.pings) {
        ++pings_;
        link_.ping_written();
      }
      if (step.message) {
        messages_.push_back(std::move(*step.message));
        link_.written(now_);
        continue;
      }
      const double ready = in_work_.empty() ? INFINITY : in_work_.front().first;
      if (std::min(step.wake_at, ready) > end) break;
      now_ = std::max(now_, std::min(step.wake_at, ready));
      if (now_ < ready) continue;
      link_.picture_drawn(now_);
      link_.picture_ready(picture_of(in_work_.front().second), now_);
      in_work_.pop_front();
    }
    now_ = end;
  }
  int count(bool is_text) const {
    return static_cast<int>(
        std::count_if(messages_.begin(), messages_.end(),
                      [&](const VisitorLink::Message& one) { return one.is_text == is_text; }));
  }
  int exact_pictures() const {
    return static_cast<int>(
        std::count_if(messages_.begin(), messages_.end(), [](const VisitorLink::Message& one) {
          return !one.is_text && (static_cast<unsigned char>(one.bytes[2]) & kLosslessFlag) != 0;
        }));
  }
  // Greets, and confirms everything until the view rests.
  void come_to_rest() {
    greet();
    for (int i = 0; i < 20; ++i) {
      pass(0.1);
      confirm_all();
    }
    ASSERT_EQ(exact_pictures(), 1);
    confirmed_before_ = static_cast<int>(received_);
    messages_.clear();
    orders_ = 0;
  }
};

TEST_F(ServeLink, the_token_is_needed_within_three_seconds) {
  EXPECT_EQ(advance().wake_at, 103);
  EXPECT_FALSE(advance(2.9).close);
  const Step late = advance(0.1);
  ASSERT_TRUE(late.close);
  EXPECT_EQ(late.close->code, CloseCode::wrong_token);
}

TEST_F(ServeLink, a_page_gets_state_a_quick_and_an_exact_picture_and_then_nothing) {
  EXPECT_EQ(greet(), Taken::hello);
  pass(0.02);
  ASSERT_GE(messages_.size(), 2u);
  EXPECT_TRUE(messages_[0].is_text);
  EXPECT_THAT(messages_[0].bytes, HasSubstr(R"("type":"state","version":1)"));
  EXPECT_FALSE(messages_[1].is_text);
  confirm();
  for (int i = 0; i < 10; ++i) {
    pass(0.1);
    confirm_all();
  }
  EXPECT_EQ(exact_pictures(), 1);
  EXPECT_EQ(orders_, 2);
  const std::size_t before = messages_.size();
  pass(1000);
  EXPECT_EQ(messages_.size(), before);
  EXPECT_EQ(advance().wake_at, INFINITY) << "a visitor at rest costs nothing";
}

TEST_F(ServeLink, nothing_is_sent_beyond_the_window) {
  greet();
  for (int i = 0; i < 20; ++i) {
    turn_wheel();
    pass(0.02);
  }
  pass(1);
  EXPECT_GE(count(false), 1);
  EXPECT_LE(count(false), 2) << "two may be in transit before the first is confirmed";
}

TEST_F(ServeLink, at_most_one_picture_is_ordered_in_a_turn_of_16_ms) {
  greet();
  for (int i = 0; i < 200; ++i) {
    turn_wheel();
    pass(0.005);
    confirm_all();
  }
  EXPECT_GT(orders_, 30);
  EXPECT_LE(orders_, 64) << "in a second";
}

TEST_F(ServeLink, two_pictures_are_in_work_at_most) {
  come_to_rest();
  int orders = 0;
  for (int i = 0; i < 20; ++i) {
    turn_wheel();
    orders += advance(0.02).order ? 1 : 0;
    if (i == 5) link_.picture_drawn(now_);
  }
  EXPECT_EQ(orders, 2) << "the second one is drawn while the first one is encoded";
}

TEST_F(ServeLink, a_state_is_sent_ten_times_a_second_at_most) {
  come_to_rest();
  for (int i = 0; i < 100; ++i) {
    turn_wheel();
    pass(0.01);
  }
  EXPECT_GE(count(true), 8);
  EXPECT_LE(count(true), 11);
}

TEST_F(ServeLink, motion_cancels_the_exact_picture) {
  greet();
  pass(0.02);
  confirm();
  Step step = advance();
  while (!(step.order && step.order->lossless)) {
    if (step.message) link_.written(now_);
    ASSERT_LT(now_, 101);
    step = advance(0.005);
  }
  EXPECT_FALSE(advance(0.001).cancels_lossless);
  turn_wheel();
  EXPECT_TRUE(advance().cancels_lossless);
  link_.picture_drawn(now_);
  link_.picture_ready(picture_of(*step.order), now_);
  pass(0.02);
  EXPECT_EQ(exact_pictures(), 0) << "one that comes too late is not sent";
}

TEST_F(ServeLink, a_message_that_does_not_leave_ends_the_connection) {
  greet();
  const Step first = advance();
  ASSERT_TRUE(first.message);
  EXPECT_LE(first.wake_at, now_ + 10);
  EXPECT_FALSE(advance(9.9).is_dead);
  EXPECT_TRUE(advance(0.2).is_dead);
}

TEST_F(ServeLink, a_message_that_is_being_written_is_finished_before_the_end) {
  greet();
  ASSERT_TRUE(advance().message);
  EXPECT_EQ(greet(), Taken::nothing);
  EXPECT_FALSE(advance(0.1).close);
  link_.written(now_);
  const Step end = advance();
  ASSERT_TRUE(end.close);
  EXPECT_EQ(end.close->code, CloseCode::too_many) << "a second hello";
  EXPECT_FALSE(end.message);
  EXPECT_FALSE(advance().close) << "it is begun once";
  EXPECT_TRUE(advance(10.1).is_dead);
}

TEST_F(ServeLink, a_page_that_says_goodbye_may_not_stay) {
  come_to_rest();
  link_.page_closes(now_);
  EXPECT_EQ(link_.next_wake(), now_ + 10);
  EXPECT_TRUE(advance(10).is_dead);
}

TEST_F(ServeLink, an_answer_before_the_ping_has_left_begins_no_second_one) {
  greet();
  const Step first = advance();
  ASSERT_TRUE(first.pings && first.order);
  in_work_.emplace_back(now_, *first.order);
  link_.written(now_);
  link_.pong(now_);  // unsolicited
  pass(0);
  for (int i = 0; i < 100; ++i) {
    turn_wheel();
    pass(0.03);
    confirm_all();
  }
  EXPECT_GT(count(false), 30);
  EXPECT_EQ(pings_, 0) << "the first one has not left";
  link_.ping_written();
  turn_wheel();
  for (int i = 0; i < 10; ++i) {
    pass(0.05);
    confirm_all();
  }
  EXPECT_EQ(pings_, 1);
}

TEST_F(ServeLink, messages_beyond_the_rate_close_the_link) {
  limits_.messages_per_second = 5;
  greet();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(say(R"({"type":"blur"})"), Taken::message);
  EXPECT_EQ(say(R"({"type":"blur"})"), Taken::nothing);
  EXPECT_EQ(advance().close->code, CloseCode::too_many);
}

}  // namespace
}  // namespace qs
