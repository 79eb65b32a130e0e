// SPDX-License-Identifier: MIT
#include "app/report/bench_report.h"

#include <cmath>
#include <limits>
#include <type_traits>

#include <fmt/format.h>

#include "app/report/markdown.h"
#include "base/json_of.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
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

}  // namespace

std::string format_csv(const std::vector<BenchRow>& rows) {
  std::string text;
  const BenchRow header;
  for_each_member(kBenchColumns, header,
                  [&](const char* name, const auto&) { text += name + ","s; });
  text.back() = '\n';
  for (const BenchRow& row : rows) {
    for_each_member(kBenchColumns, row,
                    [&](const char*, const auto& value) { text += cell(value) + ","; });
    text.back() = '\n';
  }
  return text;
}

std::string baseline_of(const BenchReport& report) {
  return report.environment.value("baseline", kUsualBaseline);
}

std::string format_ratios_csv(const BenchReport& report) {
  const std::string baseline = baseline_of(report);
  std::string text = "scene,camera,mode,pipeline,baseline,ratio,ratio_low,ratio_high,samples\n";
  for (const PairedRatio& each : paired_ratios(report.rows, baseline)) {
    const std::string cells[] = {cell(each.scene),         cell(each.camera),
                                 cell(each.mode),          cell(each.pipeline),
                                 cell(baseline),           cell(each.ratio.value),
                                 cell(low_of(each.ratio)), cell(high_of(each.ratio)),
                                 cell(each.ratio.samples)};
    text += joined(cells, ",") + "\n";
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
  return gpu.empty() ? environment.value("cpu", "unknown") : gpu;
}

std::string pipeline_note(const std::vector<BenchRow>& rows) {
  std::vector<std::string> words;
  for (const BenchRow& row : rows) {
    if (row.backend == kBackendNames[static_cast<int>(Backend::cuda)]) add_new(words, row.pipeline);
  }
  return words.empty() ? "" : "; pipeline " + joined(words, " and ");
}

}  // namespace qs
