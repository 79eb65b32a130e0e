// SPDX-License-Identifier: MIT
//
// Writes the folder of a benchmark: bench.csv, ratios.csv, bench.json, bench.md and the plots: FPS
// per mode with the range of the rounds, stacked stage times, pairs per mode, and frame time
// against the number of Gaussians if one scene was measured at several sizes.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "app/report/bench_report.h"
#include "app/report/plot.h"

namespace qs {

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
