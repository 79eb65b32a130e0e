// SPDX-License-Identifier: MIT
//
// quadsplat merge: the shards of one sweep -> the reports that one run would have written.
#include <cstdio>

#include <fmt/format.h>

#include "app/cli/command.h"
#include "app/cli/options.h"
#include "app/report/eval_report.h"
#include "app/report/merge.h"
#include "app/report/stats_file.h"
#include "app/report/write_report.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

using nlohmann::ordered_json;
using std::filesystem::path;

// What a folder may hold, and how the whole is written; a sentence when something is lacking. To
// add a report: a row here; its JSON is laid out as merge.h says.
struct ReportKind {
  const char* file;
  const char* rows;
  std::string (*write)(const ordered_json& merged, const path& folder);
};

std::string write_bench(const ordered_json& merged, const path& folder) {
  return write_report(parse_bench_report(merged), folder);
}

std::string write_eval(const ordered_json& merged, const path& folder) {
  write_eval_report(parse_eval_report(merged), folder);
  return "";
}

std::string write_render(const ordered_json& merged, const path& folder) {
  make_folder(folder);
  write_stats(folder / "stats.json", merged.dump(2) + "\n");
  return "";
}

constexpr ReportKind kKinds[] = {{"bench.json", "rows", write_bench},
                                 {"eval.json", "views", write_eval},
                                 {"stats.json", "frames", write_render}};

// The parts of a kind: in all folders or in none.
std::vector<ReportPart> read_parts(const ReportKind& kind, const std::vector<path>& folders) {
  std::vector<ReportPart> parts;
  for (const path& folder : folders) {
    if (std::filesystem::exists(folder / kind.file))
      parts.push_back(read_report_part(folder / kind.file, kind.rows));
  }
  for (const path& folder : folders) {
    if (!parts.empty() && !std::filesystem::exists(folder / kind.file))
      fail("merge: {}: holds no {}, as {} is one", folder.string(), kind.file, parts[0].from);
  }
  return parts;
}

// False when the folders hold no such report.
bool merge_kind(const ReportKind& kind, const std::vector<path>& folders, bool mixed,
                const path& out_dir) try {
  const std::vector<ReportPart> parts = read_parts(kind, folders);
  if (parts.empty()) return false;
  const ordered_json merged = merge_reports(parts, kind.rows, mixed);
  for (const std::string& sentence :
       {missing_views(merged, kind.rows), kind.write(merged, out_dir)}) {
    if (!sentence.empty()) fmt::print(stderr, "quadsplat: {}: {}\n", kind.file, sentence);
  }
  fmt::print(stderr, "wrote {}\n", (out_dir / kind.file).string());
  return true;
} catch (const nlohmann::json::exception& error) {
  fail("merge: {}: is damaged: {}", kind.file, error.what());
}

}  // namespace

int run_merge(Arguments arguments) {
  std::vector<path> folders;
  path out_dir = ".";
  bool mixed = false;
  Options options("merge", "joins the reports of bench, eval and render --shard");
  options.positionals("DIR", folders, "folders with a bench.json, eval.json or stats.json");
  options.text("--out-dir", "DIR", out_dir, "folder of the joined reports (default: this one)");
  options.flag("--mixed", mixed, "joins although GPUs, CPUs, commits or scenes differ");
  options.example("quadsplat merge shard1 shard2 --out-dir results", "two halves of a sweep");
  if (!options.parse(arguments)) return kExitOk;
  bool any = false;
  for (const ReportKind& kind : kKinds) any = merge_kind(kind, folders, mixed, out_dir) || any;
  if (!any) {
    fail("merge: {}: holds none of bench.json, eval.json, stats.json", folders.front().string());
  }
  return kExitOk;
}

}  // namespace qs
