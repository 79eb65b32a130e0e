// SPDX-License-Identifier: MIT
#include <memory>
#include <utility>

#include <dlfcn.h>

#include "raster/clock/gpu_clock.h"

namespace qs {
namespace {

// The part of NVML's binary interface that is used here, as in its API reference. The header is not
// in every CUDA installation.
using Device = void*;
using Result = int;
constexpr Result kSuccess = 0;
constexpr int kClockSm = 1;         // nvmlClockType_t
constexpr int kTemperatureGpu = 0;  // nvmlTemperatureSensors_t

// The clock event reasons that count as throttling. The others are: idle, clocks that were set by
// hand, synchronised GPUs, display clocks.
constexpr std::pair<unsigned long long, const char*> kThrottling[] = {
    {0x04, "power cap"},
    {0x20, "thermal slowdown"},
    {0x08, "hardware slowdown"},
    {0x40, "hardware thermal slowdown"},
    {0x80, "power brake"}};

/// The loaded and initialised library, with one GPU.
class Nvml {
 public:
  Nvml(const std::string& pci_bus_id, const char* library)
      : library_(dlopen(library, RTLD_NOW | RTLD_LOCAL)) {
    if (library_ == nullptr) return;
    Result (*init)() = nullptr;
    Result (*find)(const char*, Device*) = nullptr;
    load(init, "nvmlInit_v2");
    load(shutdown_, "nvmlShutdown");
    load(find, "nvmlDeviceGetHandleByPciBusId_v2");
    load(clock_, "nvmlDeviceGetClockInfo");
    load(max_clock_, "nvmlDeviceGetMaxClockInfo");
    load(reasons_, "nvmlDeviceGetCurrentClocksEventReasons");
    if (reasons_ == nullptr) load(reasons_, "nvmlDeviceGetCurrentClocksThrottleReasons");
    load(temperature_, "nvmlDeviceGetTemperature");
    load(power_, "nvmlDeviceGetPowerUsage");
    if (init == nullptr || shutdown_ == nullptr || find == nullptr || clock_ == nullptr) return;
    initialised_ = init() == kSuccess;
    found_ = initialised_ && find(pci_bus_id.c_str(), &device_) == kSuccess;
  }

  ~Nvml() {
    if (initialised_) shutdown_();
    if (library_ != nullptr) dlclose(library_);
  }

  Nvml(const Nvml&) = delete;
  Nvml& operator=(const Nvml&) = delete;

  bool found() const { return found_; }

  std::optional<double> sm_mhz_max() const { return value(max_clock_, kClockSm); }

  std::optional<GpuReading> read() const {
    const std::optional<double> mhz = value(clock_, kClockSm);
    if (!mhz) return std::nullopt;
    GpuReading reading;
    reading.sm_mhz = *mhz;
    reading.throttles = throttles();
    reading.celsius = value(temperature_, kTemperatureGpu);
    unsigned milliwatts = 0;
    if (power_ != nullptr && power_(device_, &milliwatts) == kSuccess)
      reading.watts = milliwatts / 1000.0;
    return reading;
  }

 private:
  using Query = Result (*)(Device, int, unsigned*);

  /// Leaves `function` null if the library lacks it.
  template <class Function>
  void load(Function& function, const char* name) {
    function = reinterpret_cast<Function>(dlsym(library_, name));
  }

  std::optional<double> value(Query query, int which) const {
    unsigned result = 0;
    if (query == nullptr || query(device_, which, &result) != kSuccess) return std::nullopt;
    return result;
  }

  std::optional<std::vector<std::string>> throttles() const {
    unsigned long long bits = 0;
    if (reasons_ == nullptr || reasons_(device_, &bits) != kSuccess) return std::nullopt;
    std::vector<std::string> names;
    for (const auto& [bit, name] : kThrottling)
      if ((bits & bit) != 0) names.emplace_back(name);
    return names;
  }

  void* library_;
  Device device_ = nullptr;
  bool initialised_ = false, found_ = false;
  Result (*shutdown_)() = nullptr;
  Query clock_ = nullptr, max_clock_ = nullptr, temperature_ = nullptr;
  Result (*reasons_)(Device, unsigned long long*) = nullptr;
  Result (*power_)(Device, unsigned*) = nullptr;
};

}  // namespace

GpuSensors nvml_sensors(const std::string& pci_bus_id, const char* library) {
  const auto nvml = std::make_shared<const Nvml>(pci_bus_id, library);
  if (!nvml->found()) return {};
  return {nvml->sm_mhz_max(), [nvml] { return nvml->read(); }};
}

}  // namespace qs
