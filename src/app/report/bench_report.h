// SPDX-License-Identifier: MIT
//
// What a benchmark measured: one row per (scene, camera, mode), the scenes, and the environment.
// bench.json holds all of it, so that tables and plots can be drawn again and shards merged.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/measure/bench_row.h"

namespace qs {

struct BenchReport {
  nlohmann::ordered_json environment;  ///< of environment_json(), with the command's flags
  nlohmann::ordered_json scenes;       ///< list of scene_facts()
  std::size_t view_count = 0;          ///< (scene, camera)s of the sweep, in all shards
  std::vector<BenchRow> rows;
};

inline constexpr std::size_t kMaxReportBytes = std::size_t{256} << 20;  ///< of a JSON file read

nlohmann::ordered_json rows_json(const std::vector<BenchRow>& rows);
std::vector<BenchRow> read_rows(const nlohmann::ordered_json& list);  ///< throws json::exception

std::string format_csv(const std::vector<BenchRow>& rows);
std::string format_bench_json(const BenchReport& report);

/// The report that format_bench_json() wrote. Throws json::exception.
BenchReport parse_bench_report(const nlohmann::ordered_json& json);

/// "NVIDIA H200" on CUDA, the CPU's model otherwise: what a caption says.
std::string measured_on(const nlohmann::ordered_json& environment);

/// "; pipeline fast" for rows of a backend that has several, else nothing.
std::string pipeline_note(const std::vector<BenchRow>& rows);

}  // namespace qs
