// SPDX-License-Identifier: MIT
// Compiled alone: it has a macro of its own.
//
// The clock of a GPU during a measurement, from a script of readings and from a fake NVML.
#include "raster/clock/gpu_clock.h"

#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace qs {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::IsEmpty;

using Readings = std::vector<std::optional<GpuReading>>;

// One reading of the script per call.
GpuSensors script(const Readings& readings) {
  return {1980, [readings, next = std::size_t{0}]() mutable { return readings.at(next++); }};
}

GpuReading reading(double mhz, std::vector<std::string> throttles = {}) {
  return {mhz, std::move(throttles), std::nullopt, std::nullopt};
}

// The clock after all readings of the script.
GpuClock clock_after(const Readings& readings) {
  GpuClock clock(script(readings));
  for (std::size_t i = 0; i < readings.size(); ++i)
    clock.sample(GpuClock::Time(GpuClock::kInterval * i));
  return clock;
}

TEST(GpuClock, readings_are_at_least_an_interval_apart) {
  int count = 0;
  GpuClock clock({std::nullopt, [&] {
                    ++count;
                    return std::optional(reading(1000));
                  }});
  for (int ms = 0; ms < 200; ++ms) clock.sample(GpuClock::Time(milliseconds(ms)));
  EXPECT_EQ(count, 200 / GpuClock::kInterval.count());
  EXPECT_EQ(clock.summary()->readings, static_cast<std::size_t>(count));
}

TEST(GpuClock, a_summary_has_the_range_of_all_readings_and_every_reason_once) {
  GpuReading hot = reading(1500, {"power cap", "thermal slowdown"});
  hot.celsius = 84;
  hot.watts = 700.5;
  GpuReading cool = reading(1700, {"power cap"});
  cool.celsius = 60;
  const GpuClockSummary summary = *clock_after({reading(1980), hot, std::nullopt, cool}).summary();
  EXPECT_EQ(summary.readings, 3u) << "a failed reading does not count";
  EXPECT_EQ(summary.sm_mhz.median, 1700);
  EXPECT_EQ(summary.sm_mhz.min, 1500);
  EXPECT_EQ(summary.sm_mhz.max, 1980);
  EXPECT_EQ(summary.sm_mhz_max, 1980);
  EXPECT_THAT(summary.throttled.value(), ElementsAre("power cap", "thermal slowdown"));
  EXPECT_EQ(summary.celsius->min, 60);
  EXPECT_EQ(summary.celsius->max, 84);
  EXPECT_EQ(summary.watts->median, 700.5);
}

TEST(GpuClock, without_sensors_or_readings_there_is_no_summary) {
  GpuClock blind;
  blind.sample();
  EXPECT_FALSE(blind.summary());
  EXPECT_FALSE(clock_after({std::nullopt, std::nullopt}).summary());
}

TEST(GpuClock, the_text_has_the_clock_its_range_and_the_throttling) {
  const auto text = [](const Readings& readings) {
    return clock_text("NVIDIA H200", clock_after(readings).summary());
  };
  EXPECT_EQ(text({reading(1980), reading(1980)}), "NVIDIA H200: SM clock 1,980 MHz, not throttled");
  EXPECT_EQ(text({reading(345), reading(1065), reading(1065)}),
            "NVIDIA H200: SM clock 1,065 MHz (345 to 1,065, at most 1,980), not throttled");
  EXPECT_EQ(text({reading(1755, {"power cap"}), reading(1755, {"power brake"})}),
            "NVIDIA H200: SM clock 1,755 MHz (at most 1,980), throttled: power cap, power brake");
  GpuReading silent = reading(1980);
  silent.throttles.reset();
  EXPECT_EQ(text({silent}), "NVIDIA H200: SM clock 1,980 MHz, throttling unknown");
  EXPECT_EQ(text({}), "NVIDIA H200: SM clock unknown");
}

TEST(GpuClock, only_throttling_is_warned_of) {
  EXPECT_THAT(
      throttle_warning(clock_after({reading(1000, {"power cap"}), reading(1000)}).summary()),
      testing::HasSubstr("(power cap)"));
  EXPECT_EQ(throttle_warning(clock_after({reading(1000)}).summary()), "");
  EXPECT_EQ(throttle_warning(std::nullopt), "");
}

// The reading of the GPU of fake_nvml.cpp with these clock event reasons.
GpuReading read_fake(const char* reasons) {
  setenv("FAKE_NVML_REASONS", reasons, 1);
  const GpuSensors sensors = nvml_sensors("0000:1b:00.0", FAKE_NVML);
  EXPECT_EQ(sensors.sm_mhz_max, 1980);
  return sensors.read().value();
}

class Nvml : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(FAKE_NVML)) GTEST_SKIP() << "this machine lacks " << FAKE_NVML;
  }
};

TEST_F(Nvml, reads_clock_power_and_throttling_of_the_gpu_at_an_address) {
  const GpuReading calm = read_fake("0");
  EXPECT_EQ(calm.sm_mhz, 1755);
  EXPECT_EQ(calm.watts, 412.5);
  EXPECT_EQ(calm.celsius, std::nullopt) << "the fake has no such function";
  EXPECT_THAT(calm.throttles.value(), IsEmpty());
}

TEST_F(Nvml, names_every_kind_of_throttling) {
  EXPECT_THAT(read_fake("0x4").throttles.value(), ElementsAre("power cap"));
  EXPECT_THAT(read_fake("0x20").throttles.value(), ElementsAre("thermal slowdown"));
  EXPECT_THAT(read_fake("0x48").throttles.value(),
              ElementsAre("hardware slowdown", "hardware thermal slowdown"));
  EXPECT_THAT(read_fake("0x80").throttles.value(), ElementsAre("power brake"));
}

TEST_F(Nvml, idle_gpus_and_clocks_set_by_hand_are_not_throttled) {
  EXPECT_THAT(read_fake("0x113").throttles.value(), IsEmpty());
}

TEST_F(Nvml, an_unknown_gpu_has_no_sensors) {
  EXPECT_FALSE(nvml_sensors("0000:99:00.0", FAKE_NVML).read);
}

TEST(NvmlMissing, a_machine_without_the_library_has_no_sensors) {
  EXPECT_FALSE(nvml_sensors("0000:1b:00.0", "libabsent.so.7").read);
  EXPECT_FALSE(nvml_sensors("0000:1b:00.0", "libm.so.6").read) << "another library";
}

}  // namespace
}  // namespace qs
