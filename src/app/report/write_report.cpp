// SPDX-License-Identifier: MIT
#include "app/report/write_report.h"

#include <system_error>

#include "app/base/text_file.h"
#include "app/measure/noise.h"
#include "app/report/bench_plots.h"
#include "app/report/markdown.h"
#include "raster/base/fail.h"

namespace qs {

void make_folder(const std::filesystem::path& folder) {
  if (folder.empty()) return;  // the current folder
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) fail("{}: cannot be created: {}", folder.string(), error.message());
}

std::string write_report(const BenchReport& report, const std::filesystem::path& folder) {
  make_folder(folder);
  write_text(folder / "bench.csv", format_csv(report.rows));
  write_text(folder / "ratios.csv", format_ratios_csv(report));
  write_text(folder / "bench.json", format_bench_json(report));
  write_text(folder / "bench.md", format_markdown(report) + noise_markdown(report.rows));
  if (report.rows.empty()) return "there are no rows to plot";
  return draw_plots(folder, bench_plots(report, report.environment.value("scaling", false)));
}

}  // namespace qs
