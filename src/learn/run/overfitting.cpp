// SPDX-License-Identifier: MIT
#include "learn/run/overfitting.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/text.h"
#include "learn/run/model_folder.h"
#include "raster/api/renderer.h"

namespace qs::train {
namespace {

constexpr std::size_t kFewPhotographs = 120;
constexpr double kMostLoss = 0.2;  // dB
constexpr double kMostTime = 0.03;
constexpr int kLeastInterval = 1000;
// The time of a test view, in iterations. On CUDA the picture is copied to the host and compared
// there: 15 ms for 800x600 pixels beside iterations of 0.6 to 1.2 ms (docs/log/training.md).
constexpr double kViewOnCpu = 0.6, kViewOnCuda = 24;

}  // namespace

bool keeps_best_by_default(const DataSet& data) {
  return !data.test.empty() && data.training.size() + data.test.size() < kFewPhotographs;
}

int evaluation_interval(const DataSet& data, std::string_view backend) {
  const bool cpu = backend == kBackendNames[static_cast<int>(Backend::cpu)];
  const double least =
      static_cast<double>(data.test.size()) * (cpu ? kViewOnCpu : kViewOnCuda) / kMostTime;
  return kLeastInterval * std::max(1, static_cast<int>(std::ceil(least / kLeastInterval)));
}

std::string overfitting_sentence(const TrainLog& log, const std::filesystem::path& folder) {
  const LogRow* const best = best_row(log);
  const auto last = std::find_if(log.rows.rbegin(), log.rows.rend(),
                                 [](const LogRow& row) { return row.test.has_value(); });
  if (best == nullptr || !(best->test->psnr - last->test->psnr > kMostLoss)) return "";
  const std::string iteration = grouped(static_cast<std::uint64_t>(best->iteration));
  return fmt::format(
      "overfitting: the test views have lost {} dB since iteration {} ({} dB, now {} dB); {}",
      decibels(best->test->psnr - last->test->psnr), iteration, decibels(best->test->psnr),
      decibels(last->test->psnr),
      std::filesystem::exists(gaussians_path(folder, best->iteration))
          ? fmt::format("it is saved, and --iteration {} opens it", best->iteration)
          : "--keep-best saves the best iteration of a run");
}

}  // namespace qs::train
