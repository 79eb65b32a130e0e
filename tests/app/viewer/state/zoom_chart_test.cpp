// SPDX-License-Identifier: MIT
//
// The numbers of the recorder's chart.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/viewer/state/charts.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

// Two modes, three steps up to 4x, of which `done` are measured. The times are 1, 2, 3 .. ms.
ZoomRecord some_record(std::uint64_t done = 3, double ms_factor = 1) {
  ZoomRecord record;
  record.steps = 3;
  record.closest = 0.25;
  record.modes = {1, 5};
  double ms = 0;
  for (std::uint64_t step = 0; step < done; ++step) {
    for (const CullMode mode : record.modes) {
      BenchRow& row = record.rows.emplace_back();
      row.mode = mode_name(mode);
      row.view = step;
      row.ms_median = ++ms * ms_factor;
      row.ms_spread = 0.5 * row.ms_median;
      row.pairs = 1'000'000 * static_cast<std::uint64_t>(ms);
      row.frames = 20;
    }
  }
  return record;
}

std::vector<std::string> texts(const std::vector<AxisTick>& ticks) {
  std::vector<std::string> result;
  for (const AxisTick& tick : ticks) result.push_back(tick.text);
  return result;
}

TEST(ZoomChart, curves_have_a_point_per_step_and_axes_round_ticks) {
  const ZoomRecord record = some_record();
  const ZoomChart chart = zoom_chart(&record, nullptr, ZoomQuantity::ms);
  EXPECT_EQ(chart.title, "milliseconds per frame");
  EXPECT_THAT(texts(chart.zoom_ticks), ElementsAre("1x", "2x"));
  EXPECT_THAT(texts(chart.value_ticks),
              ElementsAre("0", "2", "4", "6", "8", "10"));  // the bar ends at 9
  EXPECT_EQ(chart.most_value, 10);
  EXPECT_DOUBLE_EQ(chart.most_zoom, 4);
  ASSERT_THAT(chart.curves, SizeIs(2));
  const ZoomCurve& quadbox = chart.curves[1];
  EXPECT_EQ(quadbox.mode, 5);
  EXPECT_TRUE(quadbox.has_bars);
  EXPECT_FALSE(quadbox.is_beneath);
  ASSERT_THAT(quadbox.points, SizeIs(3));
  for (std::size_t step = 0; step < 3; ++step) {
    const ZoomPoint& point = quadbox.points[step];
    EXPECT_NEAR(point.zoom, std::exp2(step), 1e-12);
    EXPECT_EQ(point.value, 2 + 2 * static_cast<double>(step));
    EXPECT_EQ(point.low, 0.5 * point.value);
    EXPECT_EQ(point.high, 1.5 * point.value);
    EXPECT_TRUE(point.is_noisy);
  }
}

TEST(ZoomChart, frames_per_second_turn_the_bars_over_and_pairs_have_a_unit) {
  const ZoomRecord record = some_record();
  const ZoomChart fps = zoom_chart(&record, nullptr, ZoomQuantity::fps);
  EXPECT_EQ(fps.title, "frames per second");
  EXPECT_EQ(fps.curves[0].points[0].value, 1000);
  EXPECT_DOUBLE_EQ(fps.curves[0].points[0].low, 1000 / 1.5);
  EXPECT_EQ(fps.curves[0].points[0].high, 2000);
  EXPECT_THAT(texts(fps.value_ticks), ElementsAre("0", "500", "1000", "1500", "2000"));
  const ZoomChart pairs = zoom_chart(&record, nullptr, ZoomQuantity::pairs);
  EXPECT_EQ(pairs.title, "tile pairs (millions)");
  EXPECT_THAT(texts(pairs.value_ticks), ElementsAre("0", "2", "4", "6"));
  EXPECT_EQ(pairs.most_value, 6e6);
  EXPECT_FALSE(pairs.curves[0].has_bars);
  EXPECT_FALSE(pairs.curves[0].points[0].is_noisy) << "counts have no noise";
}

TEST(ZoomChart, places_are_logarithmic_in_the_zoom_and_begin_at_zero) {
  const ZoomRecord record = some_record();
  const ZoomChart chart = zoom_chart(&record, nullptr, ZoomQuantity::ms);
  EXPECT_EQ(chart.place(1, 0), glm::dvec2(0, 0));
  EXPECT_NEAR(chart.place(2, 5).x, 0.5, 1e-12);
  EXPECT_NEAR(chart.place(2, 5).y, 0.5, 1e-12);
  EXPECT_NEAR(chart.place(4, 10).x, 1, 1e-12);
}

TEST(ZoomChart, grows_step_by_step_and_its_zoom_axis_stays) {
  const ZoomRecord none = some_record(0), one = some_record(1);
  EXPECT_TRUE(zoom_chart(nullptr, nullptr, ZoomQuantity::fps).empty());
  EXPECT_TRUE(zoom_chart(&none, nullptr, ZoomQuantity::fps).empty());
  const ZoomChart chart = zoom_chart(&one, nullptr, ZoomQuantity::fps);
  ASSERT_THAT(chart.curves, SizeIs(2));
  EXPECT_THAT(chart.curves[0].points, SizeIs(1));
  EXPECT_DOUBLE_EQ(chart.most_zoom, 4);
  EXPECT_EQ(read_zoom_chart(chart, 1)->zoom, 1) << "nothing else is measured";
}

TEST(ZoomChart, a_bar_needs_five_frames_at_every_point) {
  ZoomRecord record = some_record();
  record.rows[2].frames = 4;
  const ZoomChart chart = zoom_chart(&record, nullptr, ZoomQuantity::ms);
  EXPECT_FALSE(chart.curves[0].has_bars);
  EXPECT_THAT(texts(chart.value_ticks), ElementsAre("0", "2", "4", "6")) << "no bar to show";
}

TEST(ZoomChart, bars_are_the_quartiles_of_the_frames_if_they_are_known) {
  ZoomRecord record = some_record();
  record.rows[0].turn_ms = {{9, 1, 2, 3, 4}};
  const ZoomChart ms = zoom_chart(&record, nullptr, ZoomQuantity::ms);
  EXPECT_EQ(ms.curves[0].points[0].low, 2);
  EXPECT_EQ(ms.curves[0].points[0].high, 4);
  const ZoomChart fps = zoom_chart(&record, nullptr, ZoomQuantity::fps);
  EXPECT_EQ(fps.curves[0].points[0].low, 250);
  EXPECT_EQ(fps.curves[0].points[0].high, 500);
}

TEST(ZoomChart, another_recording_is_beneath_and_widens_the_axes) {
  const ZoomRecord record = some_record();
  ZoomRecord beneath = some_record(3, 10);
  beneath.closest = 0.01;
  const ZoomChart chart = zoom_chart(&record, &beneath, ZoomQuantity::ms);
  ASSERT_THAT(chart.curves, SizeIs(4));
  EXPECT_TRUE(chart.curves[0].is_beneath && chart.curves[1].is_beneath);
  EXPECT_FALSE(chart.curves[0].has_bars);
  EXPECT_FALSE(chart.curves[3].is_beneath);
  EXPECT_DOUBLE_EQ(chart.most_zoom, 100);
  EXPECT_EQ(chart.most_value, 60);
  EXPECT_THAT(zoom_chart(&record, &record, ZoomQuantity::ms).curves, SizeIs(2));
}

TEST(ZoomChart, the_values_at_the_cursor_are_those_of_the_nearest_step) {
  const ZoomRecord record = some_record(), beneath = some_record(3, 10);
  const ZoomChart chart = zoom_chart(&record, &beneath, ZoomQuantity::ms);
  const auto reading = read_zoom_chart(chart, 0.4);
  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->zoom, 2, 1e-12);
  EXPECT_EQ(reading->title, "2x");
  ASSERT_THAT(reading->rows, SizeIs(2));
  EXPECT_EQ(reading->rows[0].mode, 1);
  EXPECT_EQ(reading->rows[0].value, "3.00");
  EXPECT_EQ(reading->rows[0].beneath, "30.0");
  EXPECT_EQ(reading->rows[1].value, "4.00");
  EXPECT_NEAR(read_zoom_chart(chart, -3)->zoom, 1, 1e-12);
  EXPECT_NEAR(read_zoom_chart(chart, 9)->zoom, 4, 1e-12);
  EXPECT_FALSE(read_zoom_chart(ZoomChart(), 0.5));
  const ZoomChart pairs = zoom_chart(&record, nullptr, ZoomQuantity::pairs);
  EXPECT_EQ(read_zoom_chart(pairs, 0)->rows[0].value, "1,000,000");
}

TEST(ZoomChart, a_recording_beneath_without_a_step_near_the_cursor_has_no_value_there) {
  const ZoomRecord record = some_record(), beneath = some_record(2);  // up to 2x
  const auto reading = read_zoom_chart(zoom_chart(&record, &beneath, ZoomQuantity::ms), 1);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->rows[0].value, "5.00");
  EXPECT_EQ(reading->rows[0].beneath, "");
}

TEST(ZoomChart, rows_without_a_time_have_no_point) {
  ZoomRecord record = some_record();
  for (BenchRow& row : record.rows) row.ms_median = 0;
  EXPECT_THAT(zoom_chart(&record, nullptr, ZoomQuantity::fps).curves, IsEmpty());
}

}  // namespace
}  // namespace qs
