// SPDX-License-Identifier: MIT
#include "app/viewer/memory_use.h"

#include <fstream>

#include <unistd.h>

#include "raster/api/renderer.h"

namespace qs {

std::uint64_t process_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t all_pages = 0, resident_pages = 0;
  file >> all_pages >> resident_pages;
  return resident_pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::uint64_t gpu_bytes(int device) {
  const GpuReport report = gpu_report();
  const auto index = static_cast<std::size_t>(device);
  if (index >= report.gpus.size()) return 0;
  return report.gpus[index].total_bytes - report.gpus[index].free_bytes;
}

}  // namespace qs
