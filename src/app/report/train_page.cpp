// SPDX-License-Identifier: MIT
#include "app/report/train_page.h"

#include <cmath>

#include <fmt/format.h>

#include "app/report/html_page.h"
#include "base/text.h"
#include "io/bytes/replace_file.h"
#include "learn/run/train_log.h"

namespace qs::train {
namespace {

constexpr const char* kAxes =
    "set xlabel \"iterations\"\nset xrange [0:*]\nset format x \"%.0f\"\nset yrange [{}]\n"
    "set key off\nset ylabel {}\n";

std::vector<std::vector<std::string>> evaluations(const TrainLog& log) {
  std::vector<std::vector<std::string>> table = {
      {"iterations", "seconds", "Gaussians", "PSNR (dB)", "SSIM"}};
  for (const LogRow& row : log.rows) {
    if (!row.test) continue;
    table.push_back({grouped(static_cast<std::uint64_t>(row.iteration)),
                     fmt::format("{:.1f}", row.seconds), grouped(row.gaussians),
                     decibels(row.test->psnr), fmt::format("{:.4f}", row.test->ssim)});
  }
  return table;
}

}  // namespace

std::vector<Plot> train_plots(const TrainLog& log, const std::string& caption) {
  if (log.rows.empty()) return {};
  // Columns: iteration, loss, Gaussians, in thousands.
  std::vector<std::string> rows, tests, reserved;
  for (const GuardRow& row : log.guard)
    reserved.push_back(fmt::format("{} {}", row.iteration, row.reserved));
  for (const LogRow& row : log.rows) {
    rows.push_back(fmt::format("{} {} {}", row.iteration, row.loss,
                               static_cast<double>(row.gaussians) / 1000));
    if (row.test && std::isfinite(row.test->psnr))
      tests.push_back(fmt::format("{} {}", row.iteration, row.test->psnr));
  }
  const auto plot = [&](const char* name, const char* title, const char* label, const char* range,
                        const std::vector<std::string>& data, const char* curve) {
    return Plot{name, title, caption,
                data_block("rows", data) + fmt::format(fmt::runtime(kAxes), range, quoted(label)) +
                    plot_command({fmt::format("$rows {} notitle", curve)})};
  };
  std::vector<Plot> plots = {plot("loss", "Training loss (mean since the row before)", "loss",
                                  "0:*", rows, "using 1:2 with lines linewidth 2")};
  const auto add_psnr = [&](const char* name, const char* title,
                            const std::vector<std::string>& data) {
    if (!data.empty())
      plots.push_back(plot(name, title, "PSNR (dB)", "*:*", data,
                           "using 1:2 with linespoints linewidth 2 pointtype 7 pointsize 1.3"));
  };
  add_psnr("psnr", "PSNR on the test views", tests);
  add_psnr("reserved", "PSNR on the reserved training views", reserved);
  plots.push_back(plot("gaussians", "Number of Gaussians", "Gaussians (thousands)", "0:*", rows,
                       "using 1:3 with lines linewidth 2"));
  return plots;
}

std::string write_train_page(const std::filesystem::path& folder, const TrainSettings& settings,
                             const TrainLog& log) {
  if (log.rows.empty()) return "";
  const std::string caption = fmt::format(
      "{}, culling mode {}; {} iterations in {:.0f} s", settings.strategy, mode_name(settings.mode),
      grouped(static_cast<std::uint64_t>(log.rows.back().iteration)), log.seconds);
  const std::vector<Plot> plots = train_plots(log, caption);
  const auto place = folder / "plots";
  make_folder(place);
  const std::string problem = draw_plots(place, plots);
  const auto shown = folder.has_filename() ? folder.filename() : folder.parent_path().filename();
  HtmlPage page("Training of " + shown.string());
  page.paragraph(caption + ".");
  if (const std::string sentence = overfitting_sentence(log, folder); !sentence.empty())
    page.paragraph(sentence + ".");
  if (!log.verdict.empty()) page.paragraph("Guard: " + log.verdict + ".");
  if (problem.empty()) {
    for (const Plot& plot : plots) page.drawing(place / (plot.name + ".svg"), plot.title);
  } else {
    page.paragraph("Without plots: " + problem + ".");
  }
  if (const auto table = evaluations(log); table.size() > 1) {
    page.heading("Evaluations");
    page.table(table);
  }
  write_text(folder / "train.html", page.text());
  return problem;
}

}  // namespace qs::train
