// SPDX-License-Identifier: MIT
//
// The clock of the GPU in a benchmark and its reports.
#include <algorithm>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/measure/measure_view.h"
#include "app/report/bench_report.h"
#include "app/report/environment.h"
#include "app/report/markdown.h"
#include "app/report/merge.h"
#include "io/bytes/json_text.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::ordered_json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

GpuClock clock_with(double mhz, std::vector<std::string> throttles) {
  GpuClock clock({1980, [=] {
                    return std::optional(GpuReading{mhz, throttles, 41, std::nullopt});
                  }});
  clock.sample();
  return clock;
}

ordered_json environment(const char* backend, const GpuClock& clock) {
  ordered_json json = {{"cpu", "some CPU"},  {"backend", backend}, {"gpu", "NVIDIA H200"},
                       {"pipeline", "fast"}, {"commit", "abc"},    {"utc", "noon"}};
  add_clock(json, clock);
  return json;
}

BenchReport report(const ordered_json& environment, std::uint64_t view = 0) {
  BenchRow row;
  row.scene = "tiny";
  row.mode = "exact";
  row.backend = "cuda";
  row.ms_median = 1;
  row.view = view;
  return {environment, ordered_json::array(), 2, {row}};
}

// Records frames and readings in their order.
class LoggingRenderer : public Renderer {
 public:
  explicit LoggingRenderer(std::string& log) : log_(log) {}
  void upload(std::shared_ptr<const GaussianCloud>, const Progress&) override {}
  const Frame& render(const Camera&, const RenderSettings&, const Outputs& outputs, const Target&,
                      std::stop_token) override {
    log_ += outputs.color ? "f" : "x";
    frame_.stats.frame_ms = 1;
    return frame_;
  }

 private:
  std::string& log_;
  Frame frame_;
};

TEST(ClockReport, readings_are_taken_between_measured_frames_only) {
  std::string log;
  Session session;
  session.renderer = std::make_unique<LoggingRenderer>(log);
  GpuClock clock({std::nullopt, [&] {
                    log += "r";
                    return std::optional(GpuReading{1000, std::nullopt, {}, {}});
                  }});
  ViewPlan plan{3, 2, 1};
  plan.clock = &clock;
  measure_view(session, {default_mode()}, test::front_camera(64, 48), plan, {});
  // Two frames of warm-up and three measured frames. These frames take far less than an interval,
  // so there is one reading, unless this thread is suspended for that long.
  EXPECT_EQ(log.substr(0, 4), "fffr");
  EXPECT_EQ(std::count(log.begin(), log.end(), 'f'), 5);
  EXPECT_EQ(clock.summary()->readings,
            static_cast<std::size_t>(std::count(log.begin(), log.end(), 'r')));
}

TEST(ClockReport, json_has_the_summary_with_null_for_unknown_values) {
  const ordered_json json = environment("cuda", clock_with(1755, {"power cap"}));
  EXPECT_EQ(json["gpu_clock"], parse_own_json(R"({
      "readings": 1, "sm_mhz": {"median": 1755.0, "min": 1755.0, "max": 1755.0},
      "sm_mhz_max": 1980.0, "throttled": ["power cap"],
      "celsius": {"median": 41.0, "min": 41.0, "max": 41.0}, "watts": null})"));
  EXPECT_TRUE(environment("cuda", GpuClock())["gpu_clock"].is_null());
  EXPECT_THAT(clock_lines(environment("cuda", GpuClock())),
              ElementsAre("NVIDIA H200: SM clock unknown"));
  EXPECT_FALSE(environment("cpu", clock_with(1980, {})).contains("gpu_clock"));
  EXPECT_THAT(clock_lines(environment("cpu", clock_with(1980, {}))), IsEmpty());
}

TEST(ClockReport, the_table_ends_with_the_clock_and_a_warning_if_the_gpu_was_throttled) {
  const auto text = [](const ordered_json& environment) {
    return format_markdown(report(environment));
  };
  EXPECT_THAT(text(environment("cuda", clock_with(1980, {}))),
              testing::EndsWith("\nNVIDIA H200: SM clock 1,980 MHz, not throttled.\n"));
  EXPECT_THAT(
      text(environment("cuda", clock_with(1500, {"power cap"}))),
      testing::EndsWith(" throttled: power cap.\n\nWarning: the GPU was throttled during the "
                        "measurement (power cap), so its times may not be comparable with "
                        "others.\n"));
  EXPECT_THAT(text(environment("cuda", GpuClock())),
              testing::EndsWith("\nNVIDIA H200: SM clock unknown.\n"));
  EXPECT_THAT(text(environment("cpu", GpuClock())), Not(HasSubstr("SM clock")));
}

TEST(ClockReport, a_merged_report_has_the_clocks_of_all_parts) {
  const TemporaryFolder folder;
  const auto part = [&](const char* name, const GpuClock& clock, std::uint64_t view) {
    std::ofstream(folder / name) << format_bench_json(report(environment("cuda", clock), view));
    return read_report_part(folder / name, "rows");
  };
  const auto merged_lines = [](const std::vector<ReportPart>& parts) {
    return clock_lines(merge_reports(parts, "rows", false)["environment"]);
  };
  const std::vector<ReportPart> calm = {part("a.json", clock_with(1980, {}), 0),
                                        part("b.json", clock_with(1980, {}), 1)};
  EXPECT_THAT(merged_lines(calm), ElementsAre("NVIDIA H200: SM clock 1,980 MHz, not throttled"));
  EXPECT_THAT(merged_lines({calm[0], part("c.json", clock_with(1500, {"power cap"}), 1)}),
              ElementsAre("NVIDIA H200: SM clock 1,980 MHz, not throttled", HasSubstr("1,500 MHz"),
                          testing::StartsWith("Warning: the GPU")));
  EXPECT_THAT(merged_lines({calm[0], part("d.json", GpuClock(), 1)}),
              ElementsAre("NVIDIA H200: SM clock 1,980 MHz, not throttled",
                          "NVIDIA H200: SM clock unknown"));
  ReportPart again = {"whole", merge_reports(calm, "rows", false)};
  EXPECT_EQ(again.report["environment"]["gpu_clock"].size(), 2u);
  const std::vector<ReportPart> one = {again};
  EXPECT_THAT(merged_lines(one), ElementsAre("NVIDIA H200: SM clock 1,980 MHz, not throttled"));
}

}  // namespace
}  // namespace qs
