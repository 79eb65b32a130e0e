// SPDX-License-Identifier: MIT
//
// A benchmark's folder: bench.csv, bench.json, bench.md and the plots. `bench` and `merge` end
// here.
#pragma once

#include <filesystem>

#include "app/report/bench_report.h"

namespace qs {

/// Makes the folder if needed. Returns one sentence when the plots could not be drawn, else "".
std::string write_report(const BenchReport& report, const std::filesystem::path& folder);

/// Makes a folder and its parents. Throws Error(input).
void make_folder(const std::filesystem::path& folder);

}  // namespace qs
