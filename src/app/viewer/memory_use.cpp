// SPDX-License-Identifier: MIT
#include "app/viewer/memory_use.h"

#include <fstream>
#include <utility>

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
  const Gpu gpu = inspect_gpu(device == kFirstGpu ? first_gpu() : device);
  return gpu.total_bytes - gpu.free_bytes;
}

MemoryWatch::MemoryWatch(std::function<std::uint64_t()> measure, std::chrono::milliseconds pause)
    : measure_(std::move(measure)),
      pause_(pause),
      thread_([this](const std::stop_token& stop) { loop(stop); }) {}

void MemoryWatch::ask() {
  {
    const std::lock_guard lock(mutex_);
    asked_ = true;
  }
  changed_.notify_all();
}

void MemoryWatch::loop(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return asked_; })) {
    asked_ = false;
    lock.unlock();
    bytes_ = measure_();
    lock.lock();
    changed_.wait_for(lock, stop, pause_, [] { return false; });
  }
}

}  // namespace qs
