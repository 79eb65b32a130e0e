// SPDX-License-Identifier: MIT
//
// quadsplat merge: the shards of one sweep -> the reports of a single run.
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "app/report/bench_report.h"
#include "app/report/eval_report.h"
#include "app/report/merge.h"
#include "app/session/session.h"
#include "base/fail.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"

namespace qs {
namespace {

using nlohmann::ordered_json;
using std::filesystem::path;

struct MergeCommand {
  std::vector<path> folders;
  path out_dir = ".";
  bool mixed = false;
};

// A report that a folder may hold. write(merged, folder) returns a warning or "". To add a report:
// a row in kKinds; its JSON has the layout of merge.h.
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
  replace_folder(folder, [&](const path& hidden) {
    write_text(hidden / "stats.json", json_file_text(merged));
  });
  return "";
}

constexpr ReportKind kKinds[] = {{"bench.json", "rows", write_bench},
                                 {"eval.json", "views", write_eval},
                                 {"stats.json", "frames", write_render}};

// The reports of one kind: either all folders hold one, or no folder does.
std::vector<ReportPart> read_parts(const ReportKind& kind, const std::vector<path>& folders) {
  std::vector<ReportPart> parts;
  for (const path& folder : folders)
    if (std::filesystem::exists(folder / kind.file))
      parts.push_back(read_report_part(folder / kind.file, kind.rows));
  for (const path& folder : folders)
    if (!parts.empty() && !std::filesystem::exists(folder / kind.file))
      fail("merge: {}: holds no {} to join with {}", folder.string(), kind.file, parts[0].from);
  return parts;
}

// Returns false if the folders hold no report of this kind.
bool merge_kind(const ReportKind& kind, const MergeCommand& command) try {
  const std::vector<ReportPart> parts = read_parts(kind, command.folders);
  if (parts.empty()) return false;
  const ordered_json merged = merge_reports(parts, kind.rows, command.mixed);
  for (const std::string& sentence :
       {missing_views(merged, kind.rows), kind.write(merged, command.out_dir)}) {
    if (!sentence.empty()) warn(fmt::format("{}: {}", kind.file, sentence));
  }
  fmt::print(stderr, "wrote {}\n", (command.out_dir / kind.file).string());
  return true;
} catch (const nlohmann::json::exception& error) {
  fail("merge: {}: is damaged: {}", kind.file, error.what());
}

int run(const MergeCommand& command) {
  for (const path& folder : command.folders) require_folder("merge", folder);
  bool any = false;
  for (const ReportKind& kind : kKinds) any = merge_kind(kind, command) || any;
  if (!any)
    fail("merge: {}: holds none of bench.json, eval.json, stats.json",
         command.folders.front().string());
  return kExitOk;
}

}  // namespace

CommandAction merge_command(Options& options) {
  const auto command = std::make_shared<MergeCommand>();
  options.positionals("DIR", command->folders, 1,
                      "folders with a bench.json, eval.json or stats.json", {"shard1", "shard2"});
  options.text("--out-dir", "DIR", command->out_dir,
               "folder of the joined reports (default: the current folder)", {"merged"});
  options.overwrite();
  options.flag("--mixed", command->mixed,
               "joins reports of different GPUs, CPUs, pipelines, commits or scenes too");
  options.example("quadsplat merge shard1 shard2 --out-dir results", "joins two halves of a sweep");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
