// SPDX-License-Identifier: MIT
#include "app/report/bench_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include <fmt/format.h>

#include "app/measure/statistics.h"
#include "app/picture/palette.h"
#include "app/report/markdown.h"
#include "base/fail.h"
#include "base/json_of.h"
#include "base/list_of.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/bytes/replace_file.h"
#include "raster/api/renderer.h"

namespace qs {
namespace {

using nlohmann::ordered_json;
using namespace std::string_literals;

std::string cell(const std::string& text) { return csv_field(text); }
std::string cell(double value) { return fmt::format("{:.4f}", value); }
template <class Integer>
requires std::is_integral_v<Integer> std::string cell(Integer value) {
  return fmt::format("{}", value);
}
template <class T>
std::string cell(const std::optional<T>& value) {
  return value ? cell(*value) : "";
}

// JSON has no infinity: it is stored as the text "inf". A missing value is null.
ordered_json to_json(const std::optional<double>& value) {
  return value && std::isinf(*value) ? ordered_json("inf") : json_of(value);
}
template <class T>
ordered_json to_json(const std::optional<T>& value) {
  return json_of(value);
}
// The lower end of a ratio's interval; unset without an interval.
std::optional<double> low_of(const Ratio& ratio) {
  return ratio.interval ? std::optional(ratio.interval->low) : std::nullopt;
}
std::optional<double> high_of(const Ratio& ratio) {
  return ratio.interval ? std::optional(ratio.interval->high) : std::nullopt;
}

template <class T>
ordered_json to_json(const T& value) {
  return value;
}

void from_json(const ordered_json& json, std::optional<double>& value) {
  if (json.is_string()) value = std::numeric_limits<double>::infinity();
  if (json.is_number()) value = json.get<double>();
}
template <class T>
void from_json(const ordered_json& json, std::optional<T>& value) {
  if (!json.is_null()) value = json_value<T>(json);
}
template <class T>
void from_json(const ordered_json& json, T& value) {
  json_value(json, value);
}

template <class T>
constexpr bool is_optional = false;
template <class T>
constexpr bool is_optional<std::optional<T>> = true;

// FPS (paper) by scene and mode, and by mode for the set of scenes, where the scene is null.
ordered_json paper_fps_json(const BenchReport& report) {
  ordered_json list = ordered_json::array();
  const auto add = [&](const ModeMean& mean, const ordered_json& scene) {
    if (!mean.fps_paper) return;
    list.push_back({{"scene", scene},
                    {"mode", mean.mode},
                    {"pipeline", mean.pipeline},
                    {"fps", *mean.fps_paper}});
  };
  const std::vector<ModeMean> means = mode_means(report.rows, baseline_of(report));
  for (const ModeMean& mean : means) add(mean, mean.scene);
  for (const ModeMean& mean : over_scenes(means)) add(mean, nullptr);
  return list;
}

// A data block per mode, and per pipeline if there are several: a line "scene values..." per scene.
template <class Values>
std::string blocks_per_mode(const std::vector<ModeMean>& means, const Values& values) {
  std::string text;
  const std::vector<std::string> labels = different(means, &ModeMean::label);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    std::vector<std::string> lines;
    for (const ModeMean& mean : means)
      if (mean.label == labels[i])
        lines.push_back(fmt::format("{} {}", quoted(mean.scene), values(mean)));
    text += data_block(fmt::format("mode{}", i), lines);
  }
  return text;
}

// Draws the blocks of blocks_per_mode(); a "{}" in `how` is the mode's marker. Plugins have colours
// and markers in their order.
std::string plot_per_mode(const std::vector<ModeMean>& means, const std::string& how) {
  std::vector<std::string> curves;
  std::vector<std::string> plugins;
  for (const ModeMean& mean : means)
    if (mean.plugin) add_new(plugins, mean.mode);
  for (const std::string& label : different(means, &ModeMean::label)) {
    const std::string mode = separated(label).front();
    const auto plugin = std::ranges::find(plugins, mode);
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
  const auto sizes = list_of<double>(means, [](const ModeMean& m) { return m.gaussians / 1e6; });
  const auto [low, high] = std::ranges::minmax_element(sizes);
  const auto tick = [](double size) { return fmt::format("\"{:.2f}\" {}", size, size); };
  return fmt::format("set xrange [{}:{}]\nset xtics ({})\n", *low / 1.2, *high * 1.2,
                     joined(list_of<std::string>(sizes, tick), ", "));
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
    for (int stage = 0; stage < kStageCount; ++stage)
      curves.push_back(fmt::format("$scene{} using {}:xtic(1) {} {}", s, stage + 2,
                                   color_option(on_white::kStages[stage]),
                                   s == 0 ? "title " + quoted(kStageNames[stage]) : "notitle"));
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
      std::ranges::all_of(means, [](const ModeMean& mean) { return mean.rounds > 1; });
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

std::string format_csv(const std::vector<BenchRow>& rows) {
  std::string text;
  const BenchRow header;
  for_each_member(kBenchColumns, header,
                  [&](const char* name, const auto&) { text += name + ","s; });
  const bool altered = std::ranges::any_of(rows, [](const auto& row) { return !!row.altered; });
  if (altered) text += "altered,";
  text.back() = '\n';
  for (const BenchRow& row : rows) {
    for_each_member(kBenchColumns, row,
                    [&](const char*, const auto& value) { text += cell(value) + ","; });
    if (altered) text += cell(row.altered) + ",";
    text.back() = '\n';
  }
  return text;
}

std::string baseline_of(const BenchReport& report) {
  return report.environment.value("baseline", kUsualBaseline);
}

std::string format_ratios_csv(const BenchReport& report) {
  const std::string baseline = baseline_of(report);
  const bool altered = !alterations_in(report.rows).empty();
  std::string text =
      fmt::format("scene,camera,mode,pipeline,baseline,ratio,ratio_low,ratio_high,samples{}\n",
                  altered ? ",altered" : "");
  for (const PairedRatio& each : paired_ratios(report.rows, baseline)) {
    const std::string cells[] = {cell(each.scene),         cell(each.camera),
                                 cell(each.mode),          cell(each.pipeline),
                                 cell(baseline),           cell(each.ratio.value),
                                 cell(low_of(each.ratio)), cell(high_of(each.ratio)),
                                 cell(each.ratio.samples)};
    text += joined(cells, ",");
    text += altered ? "," + cell(alterations_in(report.rows, each.scene)) + "\n" : "\n";
  }
  return text;
}

ordered_json rows_json(const std::vector<BenchRow>& rows) {
  ordered_json list = ordered_json::array();
  for (const BenchRow& row : rows) {
    ordered_json& json = list.emplace_back(ordered_json::object());
    const auto add = [&](const char* name, const auto& value) { json[name] = to_json(value); };
    for_each_member(kBenchColumns, row, add);
    for_each_member(kBenchDetails, row, add);
    if (row.altered) json["altered"] = *row.altered;
  }
  return list;
}

std::vector<BenchRow> read_rows(const ordered_json& list) {
  std::vector<BenchRow> rows;
  for (const ordered_json& from : list) {
    BenchRow& row = rows.emplace_back();
    const auto take = [&](const char* name, auto& value) {
      // Reports of earlier versions lack the newest columns, all of which may be empty.
      if (is_optional<std::remove_reference_t<decltype(value)>> && !from.contains(name)) return;
      from_json(from.at(name), value);
    };
    for_each_member(kBenchColumns, row, take);
    for_each_member(kBenchDetails, row, take);
    if (from.contains("altered")) row.altered = from["altered"].get<std::string>();
  }
  return rows;
}

std::string format_bench_json(const BenchReport& report) {
  ordered_json ratios = ordered_json::array();
  for (const PairedRatio& each : paired_ratios(report.rows, baseline_of(report))) {
    ratios.push_back({{"scene", each.scene},
                      {"camera", each.camera.empty() ? ordered_json() : ordered_json(each.camera)},
                      {"mode", each.mode},
                      {"pipeline", each.pipeline},
                      {"ratio", each.ratio.value},
                      {"ratio_low", to_json(low_of(each.ratio))},
                      {"ratio_high", to_json(high_of(each.ratio))},
                      {"samples", each.ratio.samples}});
  }
  ordered_json json = {{"environment", report.environment}, {"scenes", report.scenes},
                       {"view_count", report.view_count},   {"rows", rows_json(report.rows)},
                       {"baseline", baseline_of(report)},   {"ratios", ratios}};
  if (const ordered_json fps = paper_fps_json(report); !fps.empty()) json["fps_paper"] = fps;
  return json_file_text(json);
}

BenchReport parse_bench_report(const ordered_json& json) {
  return {json.at("environment"), json.at("scenes"), json_value<std::size_t>(json.at("view_count")),
          read_rows(json.at("rows"))};
}

std::string measured_on(const ordered_json& environment) {
  const std::string gpu = environment.value("gpu", "");
  if (!gpu.empty()) return gpu;
  const int threads = environment.value("threads", 0);
  return environment.value("cpu", "unknown") +
         (threads > 0 ? fmt::format(", {} thread{}", threads, threads == 1 ? "" : "s") : "");
}

std::string pipeline_note(const std::vector<BenchRow>& rows) {
  std::vector<std::string> words;
  for (const BenchRow& row : rows)
    if (row.backend == kBackendNames[static_cast<int>(Backend::cuda)]) add_new(words, row.pipeline);
  return words.empty() ? "" : "; pipeline " + joined(words, " and ");
}

std::string alterations_in(const std::vector<BenchRow>& rows, const std::string& scene) {
  std::vector<std::string> texts;
  for (const BenchRow& row : rows)
    if (row.altered && (scene.empty() || row.scene == scene)) add_new(texts, *row.altered);
  return joined(texts, "; ");
}

std::vector<Plot> bench_plots(const BenchReport& report, bool scaling) {
  const std::vector<ModeMean> means = mode_means(report.rows, baseline_of(report));
  const std::string where = caption(report, means);
  const std::string bars = fmt::format(
      "set style data histograms\nset style histogram clustered gap 2\nset yrange [0:*]\n"
      "set xlabel \"scene\"\nset xrange [-0.6:{:.1f}]\n",
      static_cast<double>(different(means, &ModeMean::scene).size()) - 0.4);
  const bool hides_bin =
      std::ranges::any_of(report.rows, [](const BenchRow& row) { return !times_bin(row); });
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
  for (Plot& plot : plots) plot.altered = alterations_in(report.rows);
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
