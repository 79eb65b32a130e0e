// SPDX-License-Identifier: MIT
#include "app/report/write_report.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/measure/noise.h"
#include "app/measure/statistics.h"
#include "app/picture/palette.h"
#include "app/report/markdown.h"
#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/bytes/text_file.h"
#include "raster/api/renderer.h"

namespace qs {
namespace {

// A data block per mode, and per pipeline if there are several: a line "scene values..." per scene.
template <class Values>
std::string blocks_per_mode(const std::vector<ModeMean>& means, const Values& values) {
  std::string text;
  const std::vector<std::string> labels = different(means, &ModeMean::label);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    std::vector<std::string> lines;
    for (const ModeMean& mean : means) {
      if (mean.label == labels[i])
        lines.push_back(fmt::format("{} {}", quoted(mean.scene), values(mean)));
    }
    text += data_block(fmt::format("mode{}", i), lines);
  }
  return text;
}

// Draws the blocks of blocks_per_mode(); a "{}" in `how` is the mode's marker. Plugins have colours
// and markers in their order.
std::string plot_per_mode(const std::vector<ModeMean>& means, const std::string& how) {
  std::vector<std::string> curves;
  std::vector<std::string> plugins;
  for (const ModeMean& mean : means) {
    if (mean.plugin) add_new(plugins, mean.mode);
  }
  for (const std::string& label : different(means, &ModeMean::label)) {
    const std::string mode = separated(label).front();
    const auto plugin = std::find(plugins.begin(), plugins.end(), mode);
    const auto number = static_cast<std::size_t>(plugin - plugins.begin());
    const bool own = plugin == plugins.end();
    curves.push_back(
        fmt::format("$mode{} {} {}", curves.size(),
                    fmt::format(fmt::runtime(how), own ? mode_marker(mode) : plugin_marker(number)),
                    own ? mode_options(mode, label) : plugin_options(number, label)));
  }
  return plot_command(curves);
}

std::string caption(const BenchReport& report, const std::vector<ModeMean>& means) {
  std::vector<std::string> sizes;
  for (const BenchRow& row : report.rows)
    add_new(sizes, fmt::format("{} x {}", row.width, row.height));
  const std::vector<std::string> scenes = different(means, &ModeMean::scene);
  return fmt::format("{}; {}; {}",
                     scenes.size() <= 3 ? joined(scenes, ", ")
                                        : fmt::format("{} .. {}", scenes.front(), scenes.back()),
                     sizes.size() == 1 ? sizes.front() : "several sizes",
                     measured_on(report.environment)) +
         pipeline_note(report.rows);
}

// The labels are the measured sizes.
std::string scaling_axis(const std::vector<ModeMean>& means) {
  std::vector<double> sizes;
  for (const ModeMean& mean : means) sizes.push_back(mean.gaussians / 1e6);
  const auto [low, high] = std::minmax_element(sizes.begin(), sizes.end());
  std::string text = fmt::format("set xrange [{}:{}]\nset xtics (", *low / 1.2, *high * 1.2);
  for (std::size_t i = 0; i < sizes.size(); ++i)
    text += fmt::format("{}\"{:.2f}\" {}", i == 0 ? "" : ", ", sizes[i], sizes[i]);
  return text + ")\n";
}

std::string stage_commands(const std::vector<ModeMean>& means) {
  const std::vector<std::string> scenes = different(means, &ModeMean::scene);
  std::string text;
  std::vector<std::string> curves;
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    std::vector<std::string> lines;
    for (const ModeMean& mean : means) {
      if (mean.scene != scenes[s]) continue;
      std::string& line = lines.emplace_back(quoted(mean.label));
      for (const double ms : mean.stage_ms) line += fmt::format(" {}", ms);
    }
    text += data_block(fmt::format("scene{}", s), lines);
    curves.push_back("newhistogram " + quoted(scenes[s]));
    for (int stage = 0; stage < kStageCount; ++stage) {
      curves.push_back(fmt::format("$scene{} using {}:xtic(1) {} {}", s, stage + 2,
                                   color_option(on_white::kStages[stage]),
                                   s == 0 ? "title " + quoted(kStageNames[stage]) : "notitle"));
    }
  }
  return text +
         "set style data histograms\nset style histogram rowstacked title offset 0,-2.0\n"
         "set boxwidth 0.8\nset key invert\nset bmargin 8.5\nset xtics rotate by -35\n"
         "set yrange [0:*]\nset ylabel \"time per frame (ms)\"\n" +
         plot_command(curves);
}

// The whiskers are the spread of the rounds: each camera's own fastest and slowest round, averaged
// over the cameras like the bar, so that differences between cameras do not count.
Plot fps_plot(const std::vector<ModeMean>& means, const std::string& where,
              const std::string& bars) {
  const bool whiskers =
      std::all_of(means.begin(), means.end(), [](const ModeMean& mean) { return mean.rounds > 1; });
  const char* note =
      whiskers ? "whiskers: slowest and fastest round of a camera" : "one round, so no whiskers";
  std::string commands =
      blocks_per_mode(means,
                      [](const ModeMean& m) {
                        return fmt::format("{} {} {}", m.fps(), 1000 / m.ms_slowest,
                                           1000 / m.ms_fastest);
                      }) +
      bars;
  if (whiskers)
    commands += fmt::format(
        "set style histogram errorbars gap 2 linewidth 1\n"
        "set errorbars front {} linewidth 1.2\n",
        color_option(kGray));
  commands += "set ylabel \"frames per second\"\n" +
              plot_per_mode(means, whiskers ? "using 2:3:4:xtic(1)" : "using 2:xtic(1)");
  return {"fps", fmt::format("Frames per second per culling mode ({})", note), where, commands};
}

}  // namespace

std::vector<Plot> bench_plots(const BenchReport& report, bool scaling) {
  const std::vector<ModeMean> means = mode_means(report.rows, baseline_of(report));
  const std::string where = caption(report, means);
  const std::string bars = fmt::format(
      "set style data histograms\nset style histogram clustered gap 2\nset yrange [0:*]\n"
      "set xlabel \"scene\"\nset xrange [-0.6:{:.1f}]\n",
      static_cast<double>(different(means, &ModeMean::scene).size()) - 0.4);
  const bool hides_bin = std::any_of(report.rows.begin(), report.rows.end(),
                                     [](const BenchRow& row) { return !times_bin(row); });
  std::vector<Plot> plots = {
      fps_plot(means, where, bars),
      {"stages",
       fmt::format("Time of the stages per culling mode (measured in a separate pass{})",
                   hides_bin ? "; fast bins in preprocess and sort" : ""),
       where, stage_commands(means)},
      {"pairs", "Tile pairs per culling mode", where,
       blocks_per_mode(means, [](const ModeMean& m) { return fmt::format("{}", m.pairs / 1e6); }) +
           bars + "set ylabel \"pairs (millions)\"\n" + plot_per_mode(means, "using 2:xtic(1)")}};
  if (scaling) {
    plots.push_back(
        {"scaling", "Frame time against scene size (copies of one scene, all in view)", where,
         blocks_per_mode(
             means,
             [](const ModeMean& m) { return fmt::format("{} {}", m.gaussians / 1e6, m.ms); }) +
             scaling_axis(means) +
             "set logscale xy 2\nset xlabel \"Gaussians (millions)\"\n"
             "set ylabel \"time per frame (ms)\"\n" +
             plot_per_mode(means,
                           "using 2:3 with linespoints pointtype {} pointsize 1.3 linewidth 1.8")});
  }
  return plots;
}

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
