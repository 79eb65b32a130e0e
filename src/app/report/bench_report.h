// SPDX-License-Identifier: MIT
//
// The result of a benchmark: one row per (scene, camera, mode), the scenes, and the environment.
// bench.json contains all of it, so that tables and plots can be made again and shards merged.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/measure/bench_row.h"
#include "app/measure/paired_ratios.h"
#include "app/report/plot.h"

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

/// The device for captions: the GPU on CUDA, else the model of the CPU and the threads in use.
std::string measured_on(const nlohmann::ordered_json& environment);

/// "; pipeline fast" if rows are from CUDA, else "".
std::string pipeline_note(const std::vector<BenchRow>& rows);

/// The alterations of the scenes of the rows, or of one scene: "splat scale 0.56"; empty without
/// any.
std::string alterations_in(const std::vector<BenchRow>& rows, const std::string& scene = {});

// Writes the folder of a benchmark: bench.csv, ratios.csv, bench.json, bench.md and the plots: FPS
// per mode with the range of the rounds, stacked stage times, pairs per mode, and frame time
// against the number of Gaussians if one scene was measured at several sizes.

/// `scaling`: the scenes are one scene at several sizes; adds the plot "scaling".
std::vector<Plot> bench_plots(const BenchReport& report, bool scaling);

/// Creates the folder if needed; all files appear in it or none. Returns one sentence if the plots
/// could not be drawn, else "".
std::string write_report(const BenchReport& report, const std::filesystem::path& folder);

/// Throws Error(usage) if a command may not write one of these files of a report to the folder,
/// because it is another file or an input (io/bytes/file_guard.h), and Error(input) if the folder's
/// name is a file's. Long commands ask before they work.
void check_report(const std::optional<std::filesystem::path>& folder,
                  std::span<const char* const> files);
inline constexpr const char* kBenchFiles[] = {"bench.csv", "ratios.csv", "bench.json", "bench.md"};
inline constexpr const char* kZoomFiles[] = {"zoom.csv", "zoom.json"};
inline constexpr const char* kEvalFiles[] = {"eval.csv", "eval.json"};
inline constexpr const char* kJudgeFiles[] = {"judge.csv", "judge.json", "sheet.png"};

}  // namespace qs
