// SPDX-License-Identifier: MIT
//
// The flow of pictures as functions of time: the window, the line's rate, codec, quality and size.
#include "app/serve/flow.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

#include <gtest/gtest.h>

#include "app/serve/quality.h"
#include "app/viewer/render/resolution.h"

namespace qs {
namespace {

// ---- the window ---------------------------------------------------------------------------------
TEST(ServeFlow, the_window_bounds_what_is_on_the_way) {
  PictureFlow flow;
  int sent = 0;
  for (; flow.has_room() && sent < 100; ++sent) flow.sent(0, 1000, false);
  EXPECT_EQ(sent, flow.window());
  EXPECT_FALSE(flow.received(static_cast<std::uint32_t>(sent + 1), 0, 0.01))
      << "more than were sent";
  EXPECT_TRUE(flow.received(static_cast<std::uint32_t>(sent), 0, 0.01));
  EXPECT_TRUE(flow.is_empty());
  EXPECT_EQ(flow.window(), 1) << "10 ms there and back need one picture on the way";
}

TEST(ServeFlow, pictures_that_are_being_made_count_too) {
  PictureFlow flow;
  ASSERT_EQ(flow.window(), 2);
  EXPECT_TRUE(flow.has_room(1));
  EXPECT_FALSE(flow.has_room(2));
  flow.sent(0, 1000, false);
  EXPECT_FALSE(flow.has_room(1));
}

TEST(ServeFlow, long_lines_get_more_and_full_ones_less) {
  PictureFlow flow;
  std::uint32_t count = 0;
  double now = 0;
  const auto one = [&](double seconds) {
    flow.sent(now, 1000, false);
    now += seconds;
    EXPECT_TRUE(flow.received(++count, 0, now));
  };
  one(0.06);
  EXPECT_EQ(flow.window(), 4);
  for (int i = 0; i < 3; ++i) one(0.15);
  EXPECT_EQ(flow.window(), 1) << "90 ms over the least time: something waits on the way";
  EXPECT_TRUE(flow.has_room());
  one(0.06);
  EXPECT_EQ(flow.window(), 4);
}

TEST(ServeFlow, the_next_room_follows_from_the_oldest_picture_and_the_slowest_of_the_last_ones) {
  PictureFlow flow;
  EXPECT_FALSE(flow.next_room(2)) << "nothing is in transit";
  double now = 0;
  std::uint32_t count = 0;
  for (const double seconds : {0.5, 0.004, 0.01, 0.006, 0.008}) {
    flow.sent(now, 1000, false);
    EXPECT_TRUE(flow.received(++count, 0, now += seconds));
  }
  ASSERT_EQ(flow.window(), 1);
  flow.sent(7, 1000, true);
  EXPECT_FALSE(flow.next_room(1)) << "parts of a picture at rest have room of their own";
  flow.sent(8, 1000, false);
  EXPECT_FALSE(flow.has_room());
  EXPECT_NEAR(flow.next_room(0).value(), 8.01, 1e-9);
  EXPECT_FALSE(flow.next_room(1)) << "a picture is made already";
}

TEST(ServeFlow, the_count_of_messages_may_wrap) {
  PictureFlow flow;
  flow.sent(0, 1000, true);
  EXPECT_FALSE(flow.received(~0u, 0, 0.01));
  EXPECT_TRUE(flow.received(1, 0, 0.01));
  EXPECT_FALSE(flow.received(0, 0, 0.01)) << "a count that goes back";
}

// ---- a line -------------------------------------------------------------------------------------
// Messages follow each other at a rate and take `trip` seconds there and back; the page confirms
// them at refreshes of its screen and may be late.
struct Line {
  explicit Line(double its_rate = 20e6, double its_trip = 0.06, double its_page = 0)
      : rate(its_rate), trip(its_trip), page(its_page) {}

  double rate, trip;  // bits per second, seconds
  double page;        // seconds that the page may be late
  double told = 0.7;  // share of them that the page knows
  double now = 0, free = 0;
  PictureFlow flow;
  std::uint32_t received = 0;
  std::deque<std::pair<double, double>> arrivals;  // confirmed at, held
  std::mt19937 random{1};

  void ping() { flow.round_trip(trip, flow.is_empty()); }
  void send(std::size_t bytes, bool is_part = false) {
    free = std::max(now, free) + 8.0 * static_cast<double>(bytes) / rate;
    flow.sent(now, bytes, is_part);
    const double late = page * std::uniform_real_distribution<double>(0, 1)(random);
    const double before = arrivals.empty() ? 0 : arrivals.back().first;
    arrivals.emplace_back(std::max(before, free + trip + late), told * late);
  }
  // Waits until the next confirmation has come.
  void wait() {
    now = std::max(now, arrivals.front().first);
    EXPECT_TRUE(flow.received(++received, arrivals.front().second, now));
    arrivals.pop_front();
  }
  void pictures(int count, std::size_t bytes, double pause) {
    for (int i = 0; i < count; ++i) {
      while (!arrivals.empty() && (arrivals.front().first <= now + pause || !flow.has_room()))
        wait();
      now += pause;
      send(bytes);
    }
    while (!arrivals.empty()) wait();
  }
};

TEST(ServeLineRate, pictures_that_leave_the_line_idle_show_its_rate) {
  for (const double rate : {1e6, 5e6, 20e6, 100e6}) {
    for (const double trip : {0.0002, 0.02, 0.06, 0.2}) {
      Line line(rate, trip);
      line.ping();
      const auto bytes = static_cast<std::size_t>(rate / 8 * 0.7 / 30);
      line.pictures(40, std::max<std::size_t>(bytes, 3000), 1.0 / 30);
      EXPECT_NEAR(line.flow.speed().estimate / rate, 1, 0.05) << rate << " " << trip;
    }
  }
}

TEST(ServeLineRate, a_page_that_is_late_does_not_change_much) {
  Line line(20e6, 0.06, 0.02);
  line.ping();
  line.pictures(60, 24000, 1.0 / 30);
  EXPECT_GT(line.flow.speed().estimate, 10e6);
  EXPECT_LT(line.flow.speed().estimate, 30e6);
  Line loopback(2e9, 0.0002, 0.01);
  loopback.ping();
  loopback.pictures(60, 81000, 1.0 / 30);
  EXPECT_GT(loopback.flow.speed().estimate, 90e6) << "JPEG";
}

TEST(ServeLineRate, large_messages_show_what_a_busy_page_hides) {
  for (const double rate : {20e6, 100e6, 300e6}) {
    Line line(rate, 0.001, 0.01);
    line.told = 0;
    line.ping();
    line.pictures(40, 24'000, 0.03);
    EXPECT_LE(line.flow.speed().estimate, 1.05 * rate) << "no more than the line carries";
    for (int part = 0; part < 30; ++part) line.send(16384, true);
    while (!line.arrivals.empty()) line.wait();
    EXPECT_NEAR(line.flow.speed().estimate / rate, 0.9, 0.15) << rate;
  }
}

TEST(ServeLineRate, one_pause_of_the_page_changes_nothing) {
  Line line(20e6, 0.06);
  line.ping();
  line.pictures(30, 24000, 1.0 / 30);
  const double before = line.flow.speed().estimate;
  line.page = 1;
  line.pictures(1, 24000, 1.0 / 30);
  line.page = 0;
  line.pictures(3, 24000, 1.0 / 30);
  EXPECT_NEAR(line.flow.speed().estimate, before, 0.1 * before);
}

TEST(ServeLineRate, a_line_that_becomes_slower_is_noticed_after_twenty_pictures) {
  Line line(20e6, 0.06);
  line.ping();
  line.pictures(60, 24000, 1.0 / 30);
  line.rate = 4e6;
  line.pictures(20, 24000, 1.0 / 30);
  EXPECT_NEAR(line.flow.speed().estimate, 4e6, 1e6);
}

TEST(ServeLineRate, small_pictures_replace_what_large_ones_have_shown) {
  Line line(500e6, 0.001);
  line.ping();
  line.pictures(20, 24000, 1.0 / 30);
  ASSERT_GT(line.flow.speed().at_least, 90e6);
  line.rate = 4e6;
  line.pictures(60, 6000, 1.0 / 30);
  EXPECT_NEAR(line.flow.speed().estimate, 4e6, 1e6);
  EXPECT_LT(line.flow.speed().at_most, 60e6) << "slow enough for video";
}

TEST(ServeLineRate, is_unknown_without_a_round_trip_and_without_large_messages) {
  Line line;
  line.pictures(5, 24000, 0.1);
  EXPECT_EQ(line.flow.speed().estimate, 0);
  line.ping();
  line.pictures(5, 100, 0.1);
  EXPECT_EQ(line.flow.speed().estimate, 0);
  line.pictures(1, 24000, 0.1);
  EXPECT_NEAR(line.flow.speed().estimate, 20e6, 1e6) << "one picture is enough";
}

TEST(ServeLineRate, a_page_s_own_claims_stay_within_bounds) {
  PictureFlow flow;
  flow.round_trip(-1, true);
  flow.sent(1, 50000, false);
  EXPECT_TRUE(flow.received(1, 10, 1.001)) << "held before it was sent";
  EXPECT_EQ(flow.speed().estimate, 1e9) << "the largest rate, as if it had taken no time";
  flow.sent(2, 50000, false);
  EXPECT_TRUE(flow.received(2, 0, 0)) << "a clock that goes back";
  EXPECT_EQ(flow.speed().estimate, 1e9);
}

TEST(ServeLineRate, the_least_round_trip_follows_the_line) {
  LineRate rate;
  rate.round_trip(0.02, true);
  rate.round_trip(0.5, false);
  EXPECT_EQ(rate.least(), 0.02) << "it has waited behind pictures";
  for (int i = 0; i < 8; ++i) rate.round_trip(0.1, true);
  EXPECT_EQ(rate.least(), 0.1) << "another line";
  rate.round_trip(0.03, false);
  EXPECT_EQ(rate.least(), 0.03);
}

// ---- parts of a picture at rest -----------------------------------------------------------------
TEST(ServeParts, fill_the_line_and_leave_it_soon) {
  for (const double rate : {5e6, 20e6}) {
    Line line(rate, 0.06);
    line.ping();
    line.pictures(10, 16000, 1.0 / 30);
    const double began = line.now;
    std::size_t sent = 0;
    double longest = 0;  // that a moving picture would wait behind parts
    while (sent < 492'000) {
      while (!line.flow.has_room_for_part(16384)) line.wait();
      EXPECT_TRUE(line.flow.has_room()) << "a moving picture has room beside parts";
      line.send(16384, true);
      sent += 16384;
      longest = std::max(longest, line.free - line.now);
    }
    while (!line.arrivals.empty()) line.wait();
    const double least = 8.0 * static_cast<double>(sent) / rate + 0.06;
    EXPECT_LT(line.now - began, 1.25 * least) << rate;
    EXPECT_LT(longest, 0.13) << rate;
  }
}

TEST(ServeParts, fill_a_line_whose_rate_was_underestimated) {
  Line line(20e6, 0.06);
  line.ping();
  for (int i = 0; i < 28; ++i) {  // the page was busy
    line.send(4000);
    line.arrivals.back().first += 0.03;
    line.wait();
    line.now += 0.03;
  }
  ASSERT_LT(line.flow.speed().estimate, 2e6);
  const double began = line.now;
  for (int sent = 0; sent < 30; ++sent) {
    while (!line.flow.has_room_for_part(16384)) line.wait();
    line.send(16384, true);
  }
  while (!line.arrivals.empty()) line.wait();
  EXPECT_LT(line.now - began, 2 * (30 * 8 * 16384 / 20e6 + 0.06));
}

TEST(ServeParts, few_are_sent_over_an_unknown_line) {
  PictureFlow flow;
  int sent = 0;
  for (; flow.has_room_for_part(16384) && sent < 100; ++sent) flow.sent(0, 16384, true);
  EXPECT_EQ(sent, 2);
}

// ---- codec, quality, size -----------------------------------------------------------------------
EncodedPicture vp9_of(int quantizer) {
  EncodedPicture picture;
  picture.codec = PictureCodec::vp9;
  picture.quantizer = quantizer;
  return picture;
}
EncodedPicture jpeg_of(std::size_t bytes) {
  EncodedPicture picture;
  picture.codec = PictureCodec::jpeg;
  picture.bytes = std::string(bytes, 'x');
  return picture;
}

LineSpeed known(double rate) { return {rate, rate, rate}; }

TEST(ServeQuality, jpeg_until_the_line_and_the_page_are_known) {
  Quality quality;
  EXPECT_EQ(quality.next(known(0)).codec, PictureCodec::jpeg);
  EXPECT_EQ(quality.next(known(0)).quality, 90);
  EXPECT_EQ(quality.next(known(5e6)).codec, PictureCodec::jpeg)
      << "the page has not said that it can";
  quality.decodes_video(true);
  EXPECT_EQ(quality.next(known(5e6)).codec, has_vp9() ? PictureCodec::vp9 : PictureCodec::jpeg);
  quality.decodes_video(false);
  EXPECT_EQ(quality.next(known(5e6)).codec, PictureCodec::jpeg);
}

TEST(ServeQuality, video_below_60_megabits_and_jpeg_again_well_above) {
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  Quality quality;
  quality.decodes_video(true);
  const auto codec = [&](double rate) { return quality.next(known(rate)).codec; };
  EXPECT_EQ(codec(100e6), PictureCodec::jpeg);
  EXPECT_EQ(codec(61e6), PictureCodec::jpeg);
  EXPECT_EQ(codec(59e6), PictureCodec::vp9);
  EXPECT_EQ(codec(80e6), PictureCodec::vp9) << "no change of codec for a rate about the limit";
  EXPECT_EQ(codec(91e6), PictureCodec::jpeg);
}

// Changes of codec over a line whose page is late by up to `page` seconds, after the first exact
// picture; the last codec.
struct CodecRun {
  int changes = 0;
  PictureCodec last = PictureCodec::none;
};
CodecRun codecs_over(double rate, double trip, double page) {
  Line line(rate, trip, page);
  line.told = 0;
  Quality quality;
  quality.decodes_video(true);
  line.ping();
  const auto rest = [&] {
    for (int part = 0; part < 30; ++part) {
      while (!line.flow.has_room_for_part(16384)) line.wait();
      line.send(16384, true);
    }
    while (!line.arrivals.empty()) line.wait();
  };
  line.pictures(1, 81'000, 0.03);
  rest();
  CodecRun run;
  for (int turn = 0; turn < 10; ++turn) {
    for (int i = 0; i < 90; ++i) {
      const PictureCodec codec = quality.next(line.flow.speed()).codec;
      run.changes += run.last != PictureCodec::none && codec != run.last ? 1 : 0;
      run.last = codec;
      line.pictures(1, codec == PictureCodec::vp9 ? 6000 : 40'000, 0.03);
    }
    rest();
    line.ping();
  }
  return run;
}

TEST(ServeQuality, loopback_gets_jpeg_and_slower_lines_video) {
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  for (const double page : {0.0, 0.002, 0.006, 0.015}) {
    const CodecRun loopback = codecs_over(2e9, 0.0002, page);
    EXPECT_EQ(loopback.last, PictureCodec::jpeg) << page;
    EXPECT_EQ(loopback.changes, 0) << page;
  }
  for (const double page : {0.0, 0.002, 0.006}) {
    for (const double rate : {5e6, 20e6, 50e6}) {
      const CodecRun slow = codecs_over(rate, 0.06, page);
      EXPECT_EQ(slow.last, PictureCodec::vp9) << rate << " " << page;
      EXPECT_LE(slow.changes, 1) << rate << " " << page;
    }
  }
}

TEST(ServeQuality, the_codec_does_not_alternate_at_the_border) {
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  for (double rate = 50e6; rate <= 110e6; rate += 5e6) {
    for (const double trip : {0.001, 0.02, 0.06}) {
      for (const double page : {0.0, 0.004})
        EXPECT_LE(codecs_over(rate, trip, page).changes, 5) << rate << " " << trip << " " << page;
    }
  }
}

TEST(ServeQuality, the_codec_changes_when_the_line_is_known_to_be_slow_or_fast) {
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  Quality quality;
  quality.decodes_video(true);
  EXPECT_EQ(quality.next({40e6, 40e6, 200e6}).codec, PictureCodec::jpeg) << "the page may be busy";
  EXPECT_EQ(quality.next({40e6, 40e6, 55e6}).codec, PictureCodec::vp9);
  EXPECT_EQ(quality.next({200e6, 50e6, 1e9}).codec, PictureCodec::vp9) << "it may be slow";
  EXPECT_EQ(quality.next({200e6, 200e6, 1e9}).codec, PictureCodec::jpeg);
}

TEST(ServeQuality, video_has_a_share_of_the_line) {
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  Quality quality;
  quality.decodes_video(true);
  EXPECT_EQ(quality.next(known(5e6)).bits_per_second, 3'500'000);
  EXPECT_EQ(quality.next(known(50e6)).bits_per_second, 8'000'000) << "no more than is visible";
  EXPECT_GT(quality.next(known(1)).bits_per_second, 0);
}

TEST(ServeQuality, every_request_of_the_page_brings_a_key_picture) {
  Quality quality;
  const std::uint32_t before = quality.next(known(5e6)).keys;
  quality.decodes_video(true);
  EXPECT_NE(quality.next(known(5e6)).keys, before);
  const std::uint32_t after = quality.next(known(5e6)).keys;
  EXPECT_EQ(quality.next(known(5e6)).keys, after);
  quality.decodes_video(true);
  EXPECT_NE(quality.next(known(5e6)).keys, after);
}

TEST(ServeQuality, ten_coarsest_pictures_make_them_smaller) {
  Quality quality;
  for (int i = 0; i < 9; ++i) quality.learn(vp9_of(kMostQuantizer), 1);
  quality.learn(vp9_of(kMostQuantizer - 1), 1);
  for (int i = 0; i < 9; ++i) quality.learn(vp9_of(kMostQuantizer), 1);
  EXPECT_EQ(quality.divisor(), 1);
  quality.learn(vp9_of(kMostQuantizer), 1);
  EXPECT_EQ(quality.divisor(), 2);
  for (int i = 0; i < 50; ++i) quality.learn(vp9_of(kMostQuantizer), 1);
  EXPECT_EQ(quality.divisor(), 2) << "pictures that were ordered before do not count";
  for (int i = 0; i < 200; ++i) quality.learn(vp9_of(kMostQuantizer), quality.divisor());
  EXPECT_EQ(quality.divisor(), kMostDivisor);
}

TEST(ServeQuality, a_slow_backend_s_reduction_is_the_start) {
  Quality quality;
  for (int i = 0; i < 10; ++i) quality.learn(vp9_of(kMostQuantizer), 3);
  EXPECT_EQ(quality.divisor(), 4);
}

TEST(ServeQuality, the_size_grows_back_and_does_not_alternate) {
  Quality quality;
  // A line on which full pictures are the coarsest ones and smaller ones easy.
  int changes = 0, before = 1;
  for (int i = 0; i < 3000; ++i) {
    quality.learn(vp9_of(quality.divisor() == 1 ? kMostQuantizer : 10), quality.divisor());
    changes += quality.divisor() != before ? 1 : 0;
    before = quality.divisor();
  }
  EXPECT_LE(changes, 20) << "each growth that fails makes the next one later";
  for (int i = 0; i < 500; ++i) quality.learn(vp9_of(10), quality.divisor());
  EXPECT_EQ(quality.divisor(), 1);
}

TEST(ServeQuality, jpeg_follows_the_rate) {
  Quality quality;
  const double rate = 10e6, budget = 0.7 * rate / 8 / 25;
  // Bytes of a JPEG picture by quality and size, about as for 1280x720.
  const auto bytes = [&] {
    const int d = quality.divisor();
    return static_cast<std::size_t>(
        81000.0 * std::pow(quality.next(known(rate)).quality / 90.0, 2) / (d * d));
  };
  for (int i = 0; i < 400; ++i) {
    const std::size_t size = bytes();
    quality.learn(jpeg_of(size), quality.divisor());
  }
  EXPECT_LE(static_cast<double>(bytes()), 1.1 * budget);
  EXPECT_GE(static_cast<double>(bytes()), 0.3 * budget) << "and uses it";
  for (int i = 0; i < 600; ++i) {
    quality.next(known(500e6));
    quality.learn(jpeg_of(50000), quality.divisor());
  }
  EXPECT_EQ(quality.next(known(500e6)).quality, 90);
  EXPECT_EQ(quality.divisor(), 1);
}

TEST(ServeQuality, the_slowest_line_gets_the_smallest_jpeg) {
  Quality quality;
  for (int i = 0; i < 400; ++i) {
    quality.next(known(50e3));
    quality.learn(jpeg_of(10000), quality.divisor());
  }
  EXPECT_EQ(quality.next(known(50e3)).quality, 40);
  EXPECT_EQ(quality.divisor(), kMostDivisor);
}

}  // namespace
}  // namespace qs
