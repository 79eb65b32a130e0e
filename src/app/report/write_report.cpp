// SPDX-License-Identifier: MIT
#include "app/report/write_report.h"

#include <system_error>

#include "app/measure/noise.h"
#include "app/report/bench_plots.h"
#include "app/report/markdown.h"
#include "base/fail.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/bytes/text_file.h"

namespace qs {

std::string write_report(const BenchReport& report, const std::filesystem::path& folder) {
  std::string problem;
  replace_folder(folder, [&](const std::filesystem::path& hidden) {
    write_text(hidden / "bench.csv", format_csv(report.rows));
    write_text(hidden / "ratios.csv", format_ratios_csv(report));
    write_text(hidden / "bench.json", format_bench_json(report));
    write_text(hidden / "bench.md", "<!-- written by quadsplat bench -->\n" +
                                        format_markdown(report) + noise_markdown(report.rows));
    problem =
        draw_plots(hidden, bench_plots(report, report.environment.value("scaling", false)), folder);
  });
  return report.rows.empty() ? "there are no rows to plot" : problem;
}

void check_report(const std::optional<std::filesystem::path>& folder,
                  std::span<const char* const> files) {
  if (!folder) return;
  check_folder(*folder);
  for (const char* file : files) check_target(*folder / file);
}

}  // namespace qs
