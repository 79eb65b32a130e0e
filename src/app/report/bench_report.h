// SPDX-License-Identifier: MIT
//
// The result of a benchmark: one row per (scene, camera, mode), the scenes, and the environment.
// bench.json contains all of it, so that tables and plots can be made again and shards merged.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/measure/bench_row.h"
#include "app/measure/paired_ratios.h"

namespace qs {

struct BenchReport {
  nlohmann::ordered_json environment;  ///< environment_json() and the command's flags
  nlohmann::ordered_json scenes;       ///< list of scene_facts()
  std::size_t view_count = 0;          ///< number of (scene, camera) pairs, in all shards
  std::vector<BenchRow> rows;
};

inline constexpr std::size_t kMaxReportBytes = std::size_t{256} << 20;  ///< limit of a JSON file

nlohmann::ordered_json rows_json(const std::vector<BenchRow>& rows);
std::vector<BenchRow> read_rows(const nlohmann::ordered_json& list);  ///< throws json::exception

std::string format_csv(const std::vector<BenchRow>& rows);

/// The mode to which all ratios of the report are relative: given by `bench --baseline`, or the
/// default.
std::string baseline_of(const BenchReport& report);

/// One line per ratio.
std::string format_ratios_csv(const BenchReport& report);

/// The ratios and the paper's FPS follow from the rows, so they are written but not parsed.
std::string format_bench_json(const BenchReport& report);

/// Parses the result of format_bench_json(). Throws json::exception.
BenchReport parse_bench_report(const nlohmann::ordered_json& json);

/// The device for captions: the GPU on CUDA, else the model of the CPU.
std::string measured_on(const nlohmann::ordered_json& environment);

/// "; pipeline fast" if rows are from CUDA, else "".
std::string pipeline_note(const std::vector<BenchRow>& rows);

}  // namespace qs
