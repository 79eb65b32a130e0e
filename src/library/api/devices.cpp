// SPDX-License-Identifier: MIT
//
// The library, its modes, and the devices of the machine.
#include <algorithm>
#include <string>
#include <thread>

#include "library/check/call.h"
#include "library/check/structs.h"
#include "quadsplat/quadsplat.h"
#include "raster/api/renderer.h"
#include "version.h"

using namespace qs::library;

namespace {

QsGpu gpu_struct(const Gpu& gpu) {
  QsGpu result{};
  result.major = gpu.major;
  result.minor = gpu.minor;
  result.total_bytes = gpu.total_bytes;
  result.free_bytes = gpu.free_bytes;
  copy_text(gpu.name, result.name, sizeof(result.name));
  copy_text(gpu.problem, result.problem, sizeof(result.problem));
  return result;
}

QsReport report_struct(const GpuReport& found) {
  QsReport report{};
  report.gpus = static_cast<std::uint32_t>(found.gpus.size());
  report.threads = std::max(1u, std::thread::hardware_concurrency());
  report.first_gpu = found.problem.empty() ? first_gpu() : -1;
  copy_text(found.driver, report.driver, sizeof(report.driver));
  copy_text(found.runtime, report.runtime, sizeof(report.runtime));
  copy_text(found.problem, report.cuda_problem, sizeof(report.cuda_problem));
  return report;
}

}  // namespace

int32_t qs_version(const char** text) {
  static const std::string kText = fmt::format("{} ({})", kVersion, kCommit);
  if (text != nullptr) *text = kText.c_str();
  return QS_LIBRARY_VERSION;
}

int32_t qs_report(QsReport* report, QsGpu* gpus, uint64_t capacity, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    const Where of_gpus{function, "gpus"};
    checked_size(report, {function, "report"});
    if (capacity > 0) checked_size(gpus, of_gpus);
    const GpuReport found = gpu_report();
    write_struct(report_struct(found), report, {function, "report"});
    const auto filled = std::min<std::uint64_t>(capacity, found.gpus.size());
    for (std::uint64_t i = 0; i < filled; ++i)
      write_struct(gpu_struct(found.gpus[i]), element(gpus, i, of_gpus), of_gpus);
  });
}

int32_t qs_mode(uint32_t number, QsMode* mode, uint32_t* count, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    const auto modes = static_cast<std::uint32_t>(mode_count()) + 1;
    if (count != nullptr) *count = modes;
    if (number >= modes) refuse({function, "number"}, "{} is not below {}", number, modes);
    const CullerRow& row = row_of(static_cast<CullMode>(number));
    write_struct(QsMode{0, row.family == CullerFamily::peers ? 1u : 0u, row.lossless ? 1u : 0u,
                        row.keeps_faint ? 1u : 0u, row.name, row.summary},
                 mode, {function, "mode"});
  });
}
