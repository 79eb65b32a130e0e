// SPDX-License-Identifier: MIT
#include "base/environment.h"

#include <ctime>
#include <fstream>
#include <thread>

#include <fmt/chrono.h>

#include "version.h"

namespace qs {
namespace {

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

Environment read_environment() {
  return {kVersion,
          kCommit,
          kBuildType,
          kSanitizers,
          kCudaToolkit,
          cpu_model(),
          static_cast<int>(std::thread::hardware_concurrency()),
          fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))};
}

}  // namespace qs
