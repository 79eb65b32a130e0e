// SPDX-License-Identifier: MIT
//
// Writes the folder of a benchmark: bench.csv, ratios.csv, bench.json, bench.md and the plots.
#pragma once

#include <filesystem>

#include "app/report/bench_report.h"

namespace qs {

/// Creates the folder if needed. Returns one sentence if the plots could not be drawn, else "".
std::string write_report(const BenchReport& report, const std::filesystem::path& folder);

/// Creates a folder and its parents. Throws Error(input).
void make_folder(const std::filesystem::path& folder);

}  // namespace qs
