// SPDX-License-Identifier: MIT
//
// quadsplat merge: the shards of one benchmark -> the report that one run would have written.
#include <cstdio>

#include <fmt/format.h>

#include "app/bench/merge.h"
#include "app/bench/write_report.h"
#include "app/command.h"
#include "app/options.h"

namespace qs {

int run_merge(Arguments arguments) {
  std::vector<std::filesystem::path> folders;
  std::filesystem::path out_dir = ".";
  bool mixed = false;
  Options options("merge", "joins the folders that bench --shard wrote");
  options.positionals("DIR", folders, "folders with a bench.json");
  options.text("--out-dir", "DIR", out_dir, "folder of the joined report (default: this one)");
  options.flag("--mixed", mixed, "joins although GPUs, CPUs or commits differ");
  options.example("quadsplat merge shard1 shard2 --out-dir results", "two halves of a sweep");
  if (!options.parse(arguments)) return kExitOk;
  std::vector<BenchReport> parts;
  for (const std::filesystem::path& folder : folders)
    parts.push_back(read_bench_json(folder / "bench.json"));
  const std::string problem = write_report(merge_reports(parts, mixed), out_dir);
  if (!problem.empty()) fmt::print(stderr, "quadsplat: {}\n", problem);
  fmt::print(stderr, "wrote {}\n", out_dir.string());
  return kExitOk;
}

}  // namespace qs
