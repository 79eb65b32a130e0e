// SPDX-License-Identifier: MIT
//
// Joins the reports of shards into what one run would have reported, times aside. A report is JSON
//   {"environment": {...}, "scene" or "scenes": ..., "view_count": N, ROWS: [{view, mode, ...},
//   ...]}
// whatever measured it; only the name of the list of rows differs.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

namespace qs {

/// One shard's report and where it was read, for messages.
struct ReportPart {
  std::string from;
  nlohmann::ordered_json report;
};

/// Reads a report and checks that it can be joined. Throws Error(input) naming the file.
ReportPart read_report_part(const std::filesystem::path& file, const char* rows);

/// Rows in the order of one run. Throws Error(input) when two parts measured the same row, and,
/// unless `mixed`, when they are not of one sweep on one machine: see kFacts in merge.cpp.
nlohmann::ordered_json merge_reports(std::span<const ReportPart> parts, const char* rows,
                                     bool mixed);

/// One sentence about views of the sweep that no part measured; empty when all are there.
std::string missing_views(const nlohmann::ordered_json& report, const char* rows);

}  // namespace qs
