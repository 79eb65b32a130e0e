// SPDX-License-Identifier: MIT
//
// The clock of a GPU while frames are measured: readings of its sensors and their summary. A slower
// clock makes every time longer, so a published time is given together with the clock.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace qs {

/// The sensors of a GPU at one moment. Values that the GPU does not report are unset.
struct GpuReading {
  double sm_mhz = 0;
  /// The reasons why the clock is lower than the load requires, in words; empty = not throttled. An
  /// idle GPU and a clock that was set by hand are not throttled.
  std::optional<std::vector<std::string>> throttles;
  std::optional<double> celsius, watts;
};

struct GpuSensors {
  std::optional<double> sm_mhz_max;  ///< the highest clock of this GPU
  /// Takes a reading in at most a few milliseconds; unset if it fails. Without sensors empty.
  std::function<std::optional<GpuReading>()> read;
};

/// The sensors of a GPU, by its index in GpuReport::gpus. Does not throw: without the driver's
/// management library there are no sensors.
GpuSensors gpu_sensors(int device);

/// The sensors of an NVIDIA GPU through NVML, the management library that comes with the driver. It
/// is loaded at run time, so a program that uses it also starts on machines without it.
/// `pci_bus_id` is the address of the GPU, such as "0000:1b:00.0": NVML numbers GPUs differently
/// from CUDA, so an index does not identify one. There are no sensors if `library` cannot be
/// loaded, is too old, or does not know the GPU.
GpuSensors nvml_sensors(const std::string& pci_bus_id, const char* library = "libnvidia-ml.so.1");

/// Over the readings of a measurement.
struct SensorRange {
  double median = 0, min = 0, max = 0;
};

struct GpuClockSummary {
  std::size_t readings = 0;
  SensorRange sm_mhz;
  std::optional<double> sm_mhz_max;                   ///< as in GpuSensors
  std::optional<std::vector<std::string>> throttled;  ///< every reason that was read at least once
  std::optional<SensorRange> celsius, watts;
};

/// Collects readings during a measurement. Without sensors it collects none.
class GpuClock {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// The shortest time between two readings.
  static constexpr std::chrono::milliseconds kInterval{50};

  explicit GpuClock(GpuSensors sensors = {}) : sensors_(std::move(sensors)) {}

  /// Takes a reading if the last attempt is at least kInterval ago. Call it between frames: a
  /// reading within a timed frame would delay it.
  void sample(Time now = std::chrono::steady_clock::now());

  /// Unset without readings.
  std::optional<GpuClockSummary> summary() const;

 private:
  GpuSensors sensors_;
  std::optional<Time> last_;
  std::vector<GpuReading> readings_;
};

/// "NVIDIA H200: SM clock 1,980 MHz, not throttled".
std::string clock_text(const std::string& gpu, const std::optional<GpuClockSummary>& summary);

/// A sentence that warns of throttling; empty if no reading shows any.
std::string throttle_warning(const std::optional<GpuClockSummary>& summary);

}  // namespace qs
