// SPDX-License-Identifier: MIT
//
// Joins the reports of shards into what one run would have reported, times aside.
#pragma once

#include <span>

#include "app/bench/bench_report.h"

namespace qs {

/// Rows in the order of one run. Throws Error(input) when two parts measured the same row, and,
/// unless `mixed`, when they come from different devices, backends or commits.
BenchReport merge_reports(std::span<const BenchReport> parts, bool mixed);

}  // namespace qs
