// SPDX-License-Identifier: MIT
#include "learn/run/train_log.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "io/bytes/json_value.h"
#include "learn/run/model_folder.h"
#include "raster/api/renderer.h"

namespace qs::train {
namespace {

constexpr std::size_t kFewPhotographs = 120;
constexpr double kMostLoss = 0.2;  // dB
constexpr double kMostTime = 0.03;
constexpr int kLeastInterval = 1000;
// The time of a test view, in iterations. On CUDA it is 0.67 ms for 800x600 pixels beside
// iterations of 0.9 ms (docs/log/training.md).
constexpr double kViewOnCpu = 0.6, kViewOnCuda = 0.7;

}  // namespace

using nlohmann::ordered_json;

void TrainLog::add(const StepResult& step) {
  loss_sum += step.loss.total;
  ++loss_count;
  for (std::size_t i = 0; i < stage_seconds.size(); ++i) {
    stage_seconds[i] += step.seconds[i];
    seconds += step.seconds[i];
  }
}

void TrainLog::close_row(const Trainer& trainer, const std::optional<Quality>& test) {
  rows.push_back({trainer.iteration(), seconds, loss_count > 0 ? loss_sum / loss_count : 0,
                  trainer.gaussians(), test, trainer.gpu_memory_bytes()});
  loss_sum = 0;
  loss_count = 0;
}

const LogRow* best_row(const TrainLog& log) {
  const LogRow* best = nullptr;
  for (const LogRow& row : log.rows)
    if (row.test && (best == nullptr || row.test->psnr > best->test->psnr)) best = &row;
  return best;
}

std::optional<std::uint64_t> most_gpu_memory(const TrainLog& log) {
  std::optional<std::uint64_t> most;
  for (const LogRow& row : log.rows) most = std::max(most, row.gpu_memory_bytes);
  return most;
}

std::string format_train_csv(const TrainLog& log) {
  const bool guarded = !log.guard.empty();
  std::string text = fmt::format("iteration,seconds,loss,gaussians,test_psnr,test_ssim{}\n",
                                 guarded ? ",reserved_psnr" : "");
  auto measured = log.guard.begin();
  for (const LogRow& row : log.rows) {
    text +=
        fmt::format("{},{:.3f},{:.6f},{},", row.iteration, row.seconds, row.loss, row.gaussians);
    text += row.test ? fmt::format("{:.4f},{:.5f}", row.test->psnr, row.test->ssim) : ",";
    std::string reserved;
    for (; measured != log.guard.end() && measured->iteration <= row.iteration; ++measured)
      reserved = fmt::format("{:.4f}", measured->reserved);
    text += guarded ? "," + reserved + "\n" : "\n";
  }
  return text;
}

ordered_json log_json(const TrainLog& log) {
  ordered_json rows = ordered_json::array();
  for (const LogRow& row : log.rows) {
    ordered_json object = {{"iteration", row.iteration},
                           {"seconds", row.seconds},
                           {"loss", row.loss},
                           {"gaussians", row.gaussians}};
    // JSON has no infinity: the PSNR of equal pictures is null.
    if (row.test) {
      object["test_psnr"] =
          std::isfinite(row.test->psnr) ? ordered_json(row.test->psnr) : ordered_json();
      object["test_ssim"] = row.test->ssim;
    }
    if (row.gpu_memory_bytes) object["gpu_memory_bytes"] = *row.gpu_memory_bytes;
    rows.push_back(object);
  }
  ordered_json stages;
  for (std::size_t i = 0; i < kTrainPasses.size(); ++i)
    stages[kTrainPasses[i]] = log.stage_seconds[i];
  ordered_json json = {{"seconds", log.seconds},
                       {"stage_seconds", stages},
                       {"evaluation_seconds", log.evaluation_seconds},
                       {"loss_sum", log.loss_sum},
                       {"loss_count", log.loss_count},
                       {"rows", rows}};
  for (const GuardRow& row : log.guard)
    json["guard"].push_back({{"iteration", row.iteration},
                             {"reserved_psnr", row.reserved},
                             {"trained_psnr", row.trained}});
  if (!log.verdict.empty()) json["verdict"] = log.verdict;
  if (!log.pace.empty()) json["pace"] = pace_json(log.pace);
  return json;
}

TrainLog log_of(const ordered_json& json) {
  TrainLog log;
  json_value(json.at("seconds"), log.seconds);
  json_value(json.at("evaluation_seconds"), log.evaluation_seconds);
  json_value(json.at("loss_sum"), log.loss_sum);
  json_value(json.at("loss_count"), log.loss_count);
  for (std::size_t i = 0; i < kTrainPasses.size(); ++i)
    json_value(json.at("stage_seconds").at(kTrainPasses[i]), log.stage_seconds[i]);
  for (const ordered_json& object : json.at("rows")) {
    LogRow row;
    json_value(object.at("iteration"), row.iteration);
    json_value(object.at("seconds"), row.seconds);
    json_value(object.at("loss"), row.loss);
    json_value(object.at("gaussians"), row.gaussians);
    if (object.contains("test_ssim")) {
      const ordered_json& psnr = object.at("test_psnr");
      row.test = Quality{psnr.is_null() ? INFINITY : json_value<double>(psnr),
                         json_value<double>(object.at("test_ssim"))};
    }
    if (object.contains("gpu_memory_bytes"))
      row.gpu_memory_bytes = json_value<std::uint64_t>(object.at("gpu_memory_bytes"));
    log.rows.push_back(row);
  }
  if (json.contains("guard"))
    for (const ordered_json& object : json.at("guard"))
      log.guard.push_back({json_value<int>(object.at("iteration")),
                           json_value<double>(object.at("reserved_psnr")),
                           json_value<double>(object.at("trained_psnr"))});
  if (json.contains("verdict")) json_value(json.at("verdict"), log.verdict);
  if (json.contains("pace")) log.pace = pace_of(json.at("pace"));
  return log;
}

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
