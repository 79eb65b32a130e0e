// SPDX-License-Identifier: MIT
//
// Merges the reports of shards into the report of one run with all views. A report is JSON
//   {"environment": {...}, "scene" or "scenes": ..., "view_count": N, ROWS: [{view, mode, ...},
//   ...]}
// `bench`, `eval` and `render` differ only in the name of the list of rows.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

namespace qs {

/// The report of one shard, and its file for messages.
struct ReportPart {
  std::string from;
  nlohmann::ordered_json report;
};

/// Reads a report and checks its structure. Throws Error(input) naming the file.
ReportPart read_report_part(const std::filesystem::path& file, const char* rows);

/// Rows are in the order of one run. Throws Error(input) if two parts contain the same row, and,
/// unless `mixed`, if a fact of kFacts (merge.cpp) differs, such as the device.
nlohmann::ordered_json merge_reports(std::span<const ReportPart> parts, const char* rows,
                                     bool mixed);

/// One sentence about the views that no part contains, or "".
std::string missing_views(const nlohmann::ordered_json& report, const char* rows);

}  // namespace qs
