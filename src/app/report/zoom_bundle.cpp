// SPDX-License-Identifier: MIT
#include "app/report/zoom_bundle.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/measure/camera_path.h"
#include "app/measure/scene_facts.h"
#include "app/measure/statistics.h"
#include "app/picture/legend.h"
#include "app/picture/palette.h"
#include "app/report/environment.h"
#include "app/session/alterations.h"
#include "app/session/shot.h"
#include "base/fail.h"
#include "base/json_of.h"
#include "base/list_of.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "io/bytes/file_hash.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/bytes/replace_file.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

template <class Vector>
void read_vector(const ordered_json& json, Vector& vector) {
  for (int c = 0; c < 3; ++c) json.at(static_cast<std::size_t>(c)).get_to(vector[c]);
}

constexpr double kRoundingSlack = 1e-9;  ///< relative slack when ticks are compared

// Columns of a mode's data block. Behind FPS and milliseconds are the ends of their bars; noisy
// values are NaN at other steps.
constexpr int kZoom = 1, kFps = 2, kMs = 5, kPairs = 8, kBarZoom = 9, kNoisyFps = 10, kNoisyMs = 11;

// The bars of a step stand side by side, 0.6 % of the axis apart but within 0.6 of the way to the
// next step, so that no mode hides another.
std::string blocks(const ZoomBundle& bundle) {
  std::string text;
  const auto modes = static_cast<double>(bundle.modes.size());
  for (std::size_t m = 0; m < bundle.modes.size(); ++m) {
    const double apart = std::min(0.006, 0.6 / (modes * (bundle.steps - 1)));
    const double aside =
        std::pow(bundle.closest, -apart * (static_cast<double>(m) - 0.5 * (modes - 1)));
    std::vector<std::string> lines;
    for (std::size_t i = m; i < bundle.rows.size(); i += bundle.modes.size()) {
      const BenchRow& row = bundle.rows[i];
      const double zoom = zoom_factor(row, bundle.steps, bundle.closest);
      const auto [low, high] = middle_half(row);
      lines.push_back(fmt::format(
          "{} {} {} {} {} {} {} {} {:.6g} {}", zoom, row.fps_median, 1000 / high, 1000 / low,
          row.ms_median, low, high, static_cast<double>(row.pairs) / 1e6, zoom * aside,
          is_noisy_step(row) ? fmt::format("{} {}", row.fps_median, row.ms_median) : "NaN NaN"));
    }
    text += data_block(fmt::format("mode{}", m), lines);
  }
  return text;
}

// Bars come first, so that all curves are drawn over them. quadbox-naive lists the same pairs as
// quadbox: its wider curve stays visible under the other. `noisy`: the column of rings; 0: without
// bars and rings.
std::string curves(const ZoomBundle& bundle, int column, int noisy) {
  constexpr const char* kRing = "linewidth 1.5 pointtype 6 pointsize 2.6";
  std::vector<std::string> bars, rings, lines;
  for (std::size_t m = 0; m < bundle.modes.size(); ++m) {
    const std::string mode = mode_name(bundle.modes[m]), color = mode_color_option(mode);
    bars.push_back(
        fmt::format("$mode{0} using {1}:{2}:{3}:{4}:{2} with financebars {5} linewidth 1.5 notitle",
                    m, kBarZoom, column, column + 1, column + 2, color));
    rings.push_back(fmt::format("$mode{} using {}:{} with points {} {} notitle", m, kZoom, noisy,
                                color, kRing));
    lines.push_back(
        fmt::format("$mode{} using {}:{} with linespoints linewidth {} pointtype {} pointsize 1.3 "
                    "pointinterval {} {}",
                    m, kZoom, column, mode == "quadbox-naive" ? 4.0 : 1.8, mode_marker(mode),
                    std::max(1, bundle.steps / 8), mode_options(mode, mode)));
  }
  if (noisy != 0 && has_bars(bundle.rows)) lines.insert(lines.begin(), bars.begin(), bars.end());
  if (noisy != 0 && std::ranges::any_of(bundle.rows, is_noisy_step)) {
    lines.insert(lines.end(), rings.begin(), rings.end());
    lines.push_back(fmt::format("NaN with points {} {} title \"noisy step\"",
                                color_option(on_white::kInk), kRing));
  }
  return plot_command(lines);
}

// The noisy steps are named below the axis, where there is room for all modes.
std::string x_axis(const ZoomBundle& bundle, bool has_times) {
  const double most = 1 / bundle.closest, margin = std::pow(most, 0.02);
  std::vector<std::string> ticks;
  for (const AxisTick& tick : zoom_ticks(most))
    ticks.push_back(fmt::format("{} {}", quoted(tick.text), tick.value));
  const std::string noisy = has_times ? noisy_steps(bundle.rows) : "";
  return fmt::format(
      "set logscale x 2\nset errorbars 0\nset yrange [0:*]\nset xrange [{:.6g}:{:.6g}]\nset xtics "
      "({})\n"
      "set xlabel \"zoom (first distance to the target / distance)\"{}\n",
      1 / margin, most * margin, joined(ticks, ", "),
      noisy.empty() ? "" : " . \"\\n\" . " + quoted("noisy steps: " + noisy));
}

// "; medians of 20 frames"
std::string frames_note(const std::vector<BenchRow>& rows) {
  const std::uint64_t frames = frames_per_point(rows);
  if (frames == 0) return "";
  return frames == 1 ? "; single frames" : fmt::format("; medians of {} frames", frames);
}

// The distance of round ticks: 1, 2 or 5 times a power of ten, at most `steps` of them up to
// `most`.
double tick_step(double most, double steps) {
  const double rough = most / steps;
  return round_step(rough, [&](double step) { return step >= rough * (1 - kRoundingSlack); });
}

int decimals_of(double step) {
  return std::max(0, -static_cast<int>(std::floor(std::log10(step) + kRoundingSlack)));
}

}  // namespace

std::string format_zoom_json(const ZoomBundle& bundle) {
  const RenderSettings& settings = bundle.settings;
  ordered_json json = {{"environment", bundle.environment},
                       {"scene", bundle.scene.string()},
                       {"scene_hash", bundle.scene_hash},
                       {"altered", bundle.altered},
                       {"start", camera_json(bundle.start)},
                       {"target", {bundle.target.x, bundle.target.y, bundle.target.z}},
                       {"steps", bundle.steps},
                       {"closest", bundle.closest},
                       {"modes", list_of<ordered_json>(bundle.modes, mode_name)},
                       {"settings",
                        {{"sh_degree", settings.sh_degree},
                         {"splat_scale", settings.splat_scale},
                         {"background", json_of(settings.background)},
                         {"antialiased", json_of(settings.antialiased)}}},
                       {"noisy_steps", noisy_steps(bundle.rows)},
                       {"rows", rows_json(bundle.rows)}};
  if (settings.style != DrawStyle::splats)
    json["settings"]["style"] = kDrawStyleNames[static_cast<int>(settings.style)];
  if (bundle.altered.is_null()) json.erase("altered");
  return json_file_text(json);
}

ZoomBundle read_zoom_json(const std::filesystem::path& path) try {
  const ordered_json json = parse_own_json(read_text_file(path, kMaxReportBytes));
  ZoomBundle bundle;
  bundle.environment = json.at("environment");
  bundle.scene = json.at("scene").get<std::string>();
  json.at("scene_hash").get_to(bundle.scene_hash);
  bundle.altered = json.value("altered", ordered_json());
  bundle.start = camera_of(json.at("start"), path.string());
  read_vector(json.at("target"), bundle.target);
  json_value(json.at("steps"), bundle.steps);
  json.at("closest").get_to(bundle.closest);
  if (bundle.steps < 2 || bundle.steps > 100000 || !(bundle.closest > 0))
    fail("{}: steps or closest is out of range", path.string());
  for (const ordered_json& name : json.at("modes")) {
    const CullMode mode = find_culler(name.get<std::string>());
    if (mode < 0) fail("{}: there is no mode {}", path.string(), json_line(name));
    bundle.modes.push_back(mode);
  }
  const ordered_json& settings = json.at("settings");
  json_value(settings.at("sh_degree"), bundle.settings.sh_degree);
  settings.at("splat_scale").get_to(bundle.settings.splat_scale);
  const std::string style = settings.value("style", kDrawStyleNames[0]);
  const auto found = std::ranges::find(kDrawStyleNames, style);
  if (found == std::end(kDrawStyleNames)) fail("{}: there is no style {}", path.string(), style);
  bundle.settings.style = static_cast<DrawStyle>(found - kDrawStyleNames);
  read_vector(settings.at("background"), bundle.settings.background);
  if (const ordered_json& antialiased = settings.at("antialiased"); !antialiased.is_null())
    bundle.settings.antialiased = antialiased.get<bool>();
  bundle.rows = read_rows(json.at("rows"));
  return bundle;
} catch (const nlohmann::json::exception& error) {
  fail("{}: is not a zoom's zoom.json: {}", path.string(), error.what());
}

std::vector<std::string> count_differences(const std::vector<BenchRow>& recorded,
                                           const std::vector<BenchRow>& replayed) {
  std::vector<std::string> sentences;
  if (recorded.size() != replayed.size()) {
    sentences.push_back(
        fmt::format("the bundle has {} rows, the replay {}", recorded.size(), replayed.size()));
    return sentences;
  }
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    const BenchRow &was = recorded[i], &is = replayed[i];
    if (was.mode == is.mode && was.pairs == is.pairs && was.visible == is.visible) continue;
    sentences.push_back(fmt::format("step {}, {}: {} pairs of {} Gaussians, recorded {} of {}",
                                    is.camera, is.mode, is.pairs, is.visible, was.pairs,
                                    was.visible));
  }
  return sentences;
}

std::uint64_t frames_per_point(const std::vector<BenchRow>& rows) {
  if (rows.empty()) return 0;
  std::uint64_t fewest = rows.front().frames.value_or(0);
  for (const BenchRow& row : rows) fewest = std::min(fewest, row.frames.value_or(0));
  return fewest;
}

bool has_bars(const std::vector<BenchRow>& rows) {
  return frames_per_point(rows) >= kFewestBarFrames;
}

MiddleHalf middle_half(const BenchRow& row) {
  if (row.turn_ms && !row.turn_ms->empty())
    return {percentile(*row.turn_ms, 0.25), percentile(*row.turn_ms, 0.75)};
  const double ms = row.ms_median, spread = spread_ms(row).value_or(0);
  return {std::max(ms - spread, 0.1 * ms), ms + spread};
}

std::string zoom_caption(const ZoomBundle& bundle, bool has_times) {
  const BenchRow& row = bundle.rows.front();
  return fmt::format("{}; {} x {}; {}", row.scene, row.width, row.height,
                     measured_on(bundle.environment)) +
         pipeline_note(bundle.rows) + (has_times ? frames_note(bundle.rows) : "");
}

double zoom_factor(const BenchRow& row, int steps, double closest) {
  return std::pow(closest, -static_cast<double>(row.view) / (steps - 1));
}

std::vector<AxisTick> zoom_ticks(double most) {
  constexpr double kFewestOctaves = 2;  // below it the distances are round, not the ratios
  const double end = most * (1 + kRoundingSlack);
  std::vector<AxisTick> ticks;
  if (most < kFewestOctaves) {
    const double step = tick_step(most - 1, 4);
    for (int i = 0; 1 + i * step <= end; ++i)
      ticks.push_back({1 + i * step, fmt::format("{:.{}f}x", 1 + i * step, decimals_of(step))});
    return ticks;
  }
  for (double power = 1; power <= end; power *= 10)
    for (const double factor : {1.0, 2.0, 5.0})
      if (factor * power <= end)
        ticks.push_back({factor * power, fmt::format("{:.0f}x", factor * power)});
  return ticks;
}

std::vector<AxisTick> round_ticks(double most) {
  constexpr double kMostSteps = 5;
  const double step = tick_step(most, kMostSteps);
  const int count = std::max(1, static_cast<int>(std::ceil(most / step * (1 - kRoundingSlack))));
  std::vector<AxisTick> ticks;
  for (int i = 0; i <= count; ++i)
    ticks.push_back({i * step, fmt::format("{:.{}f}", i * step, decimals_of(step))});
  return ticks;
}

std::vector<Plot> zoom_plots(const ZoomBundle& bundle) {
  if (bundle.rows.empty()) return {};
  const bool bars = has_bars(bundle.rows);
  const std::string note = bars ? " (bars: the middle half of the frames)" : "";
  const auto plot = [&](const char* name, const std::string& title, const char* label, int column,
                        int noisy) {
    const bool has_times = noisy != 0;
    return Plot{name, title, zoom_caption(bundle, has_times),
                blocks(bundle) + x_axis(bundle, has_times) +
                    fmt::format("set ylabel {}\n", quoted(label)) + curves(bundle, column, noisy),
                alterations_in(bundle.rows)};
  };
  return {
      plot("zoom_fps", "Frames per second while zooming in" + note, "frames per second", kFps,
           kNoisyFps),
      plot("zoom_ms", "Frame time while zooming in" + note, "time per frame (ms)", kMs, kNoisyMs),
      plot("zoom_pairs", "Tile pairs while zooming in", "pairs (millions)", kPairs, 0)};
}

ZoomBundle start_zoom(const Session& session, const Camera& start, glm::dvec3 target) {
  return {.scene = std::filesystem::absolute(session.scene->path),
          .scene_hash = file_hash(session.scene->path),
          .start = start,
          .target = target,
          .modes = all_modes(),
          .settings = session.settings,
          .altered = alterations_of(session).json,
          .environment = environment_json(session)};
}

std::vector<BenchRow> measure_zoom_step(Session& session, const ZoomBundle& bundle,
                                        std::size_t step, const ViewPlan& plan,
                                        const Progress& progress) {
  const Camera camera = zoom_camera(bundle.start, bundle.target, bundle.steps, bundle.closest,
                                    static_cast<int>(step));
  ViewPlan turned = plan;
  turned.first_round = step;
  std::vector<BenchRow> rows = measure_view(session, bundle.modes, camera, turned, progress);
  for (BenchRow& row : rows) {
    row.scene = scene_name(session.scene->path);
    row.camera = fmt::format("{}", step);
    row.view = step;
  }
  return rows;
}

std::vector<BenchRow> record_zoom(Session& session, const ZoomBundle& bundle, const ViewPlan& plan,
                                  const Progress& progress) {
  std::vector<BenchRow> rows;
  const auto steps = static_cast<std::size_t>(bundle.steps);
  for (std::size_t step = 0; step < steps; ++step) {
    const Progress part = step_of(progress, step, steps);
    part.update(0);
    const std::vector<BenchRow> measured = measure_zoom_step(session, bundle, step, plan, part);
    rows.insert(rows.end(), measured.begin(), measured.end());
  }
  return rows;
}

std::string save_zoom(Session& session, const ZoomBundle& bundle,
                      const std::filesystem::path& folder) {
  const std::vector<Camera> path =
      zoom_path(bundle.start, bundle.target, bundle.steps, bundle.closest);
  std::string problem;
  replace_folder(folder, [&](const std::filesystem::path& hidden) {
    write_text(hidden / "zoom.csv", format_csv(bundle.rows));
    write_text(hidden / "zoom.json", format_zoom_json(bundle));
    RenderSettings settings = bundle.settings;
    settings.mode = default_mode();
    for (const std::size_t step : {std::size_t{0}, path.size() / 2, path.size() - 1}) {
      if (std::filesystem::absolute(session.scene->path) != bundle.scene) break;
      write_image(session.renderer->render(path[step], settings).color,
                  hidden / fmt::format("step_{:04}.png", step), altered_metadata(session));
    }
    problem = draw_plots(hidden, zoom_plots(bundle), folder);
  });
  return problem;
}

}  // namespace qs
