// SPDX-License-Identifier: MIT
//
// A library with the functions of NVML that nvml.cpp calls, for a machine with one GPU. The
// reasons for throttling are the environment variable FAKE_NVML_REASONS, a number.
#include <cstdlib>
#include <cstring>

namespace {

constexpr int kSuccess = 0, kNotSupported = 3, kNotFound = 6;
int gpu = 0;  // its address is the handle of the GPU
bool initialised = false;

int value(void* device, unsigned* result, unsigned value) {
  if (!initialised || device != &gpu) return kNotFound;
  *result = value;
  return kSuccess;
}

}  // namespace

extern "C" {

int nvmlInit_v2() {
  initialised = true;
  return kSuccess;
}

int nvmlShutdown() {
  initialised = false;
  return kSuccess;
}

int nvmlDeviceGetHandleByPciBusId_v2(const char* address, void** device) {
  if (!initialised || std::strcmp(address, "0000:1b:00.0") != 0) return kNotFound;
  *device = &gpu;
  return kSuccess;
}

int nvmlDeviceGetClockInfo(void* device, int type, unsigned* mhz) {
  return type == 1 ? value(device, mhz, 1755) : kNotSupported;  // 1: streaming multiprocessors
}

int nvmlDeviceGetMaxClockInfo(void* device, int type, unsigned* mhz) {
  return type == 1 ? value(device, mhz, 1980) : kNotSupported;
}

// The name before version 12 of NVML.
int nvmlDeviceGetCurrentClocksThrottleReasons(void* device, unsigned long long* reasons) {
  const char* text = std::getenv("FAKE_NVML_REASONS");
  if (device != &gpu || text == nullptr) return kNotSupported;
  *reasons = std::strtoull(text, nullptr, 0);
  return kSuccess;
}

int nvmlDeviceGetPowerUsage(void* device, unsigned* milliwatts) {
  return value(device, milliwatts, 412500);
}

}  // extern "C"
