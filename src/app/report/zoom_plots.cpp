// SPDX-License-Identifier: MIT
#include "app/report/zoom_plots.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/measure/noise.h"
#include "app/picture/scale.h"
#include "base/text.h"

namespace qs {
namespace {

constexpr double kRoundingSlack = 1e-9;  ///< relative slack when ticks are compared

// Columns of a mode's data block.
enum Column { kZoom = 1, kFps, kFpsLow, kFpsHigh, kMs, kMsLow, kMsHigh, kPairs };

std::string blocks(const ZoomBundle& bundle) {
  std::string text;
  for (std::size_t m = 0; m < bundle.modes.size(); ++m) {
    std::vector<std::string> lines;
    for (std::size_t i = m; i < bundle.rows.size(); i += bundle.modes.size()) {
      const BenchRow& row = bundle.rows[i];
      lines.push_back(fmt::format("{} {} {} {} {} {} {} {}",
                                  zoom_factor(row, bundle.steps, bundle.closest), row.fps_median,
                                  1000 / row.ms_p95, 1000 / row.ms_p05, row.ms_median, row.ms_p05,
                                  row.ms_p95, static_cast<double>(row.pairs) / 1e6));
    }
    text += data_block(fmt::format("mode{}", m), lines);
  }
  return text;
}

// Bands come first, so that all curves are drawn over them. quadbox-naive lists the same pairs as
// quadbox: its wider curve stays visible under the other.
std::string curves(const ZoomBundle& bundle, int column, bool band) {
  std::vector<std::string> bands, lines;
  for (std::size_t m = 0; m < bundle.modes.size(); ++m) {
    const std::string mode = mode_name(bundle.modes[m]);
    bands.push_back(fmt::format(
        "$mode{} using {}:{}:{} with filledcurves {} fillstyle transparent solid 0.2 noborder "
        "notitle",
        m, static_cast<int>(kZoom), column + 1, column + 2, mode_color_option(mode)));
    lines.push_back(
        fmt::format("$mode{} using {}:{} with linespoints linewidth {} pointtype {} pointsize 1.3 "
                    "pointinterval {} {}",
                    m, static_cast<int>(kZoom), column, mode == "quadbox-naive" ? 4.0 : 1.8,
                    mode_marker(mode), std::max(1, bundle.steps / 8), mode_options(mode, mode)));
  }
  if (band) lines.insert(lines.begin(), bands.begin(), bands.end());
  return plot_command(lines);
}

// The noisy steps are named below the axis, where there is room for all modes.
std::string x_axis(const ZoomBundle& bundle) {
  const double most = 1 / bundle.closest;
  std::vector<std::string> ticks;
  for (const AxisTick& tick : zoom_ticks(most))
    ticks.push_back(fmt::format("{} {}", quoted(tick.text), tick.value));
  const std::string noisy = noisy_steps(bundle.rows);
  return fmt::format(
      "set logscale x 2\nset yrange [0:*]\nset xrange [1:{}]\nset xtics ({})\n"
      "set xlabel \"zoom (first distance to the target / distance)\"{}\n",
      most, joined(ticks, ", "),
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

std::uint64_t frames_per_point(const std::vector<BenchRow>& rows) {
  if (rows.empty()) return 0;
  std::uint64_t fewest = rows.front().frames.value_or(0);
  for (const BenchRow& row : rows) fewest = std::min(fewest, row.frames.value_or(0));
  return fewest;
}

bool has_bands(const std::vector<BenchRow>& rows) {
  return frames_per_point(rows) >= kFewestBandFrames;
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
  for (double power = 1; power <= end; power *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (factor * power <= end)
        ticks.push_back({factor * power, fmt::format("{:.0f}x", factor * power)});
    }
  }
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
  const BenchRow& row = bundle.rows.front();
  const std::string caption = fmt::format("{}; {} x {}; {}", row.scene, row.width, row.height,
                                          measured_on(bundle.environment)) +
                              pipeline_note(bundle.rows) + frames_note(bundle.rows);
  const bool bands = has_bands(bundle.rows);
  const std::string note = bands ? " (band: 5-95 % of the frames)" : "";
  const auto plot = [&](const char* name, const std::string& title, const char* label, int column,
                        bool band) {
    return Plot{name, title, caption,
                blocks(bundle) + x_axis(bundle) + fmt::format("set ylabel {}\n", quoted(label)) +
                    curves(bundle, column, band)};
  };
  return {plot("zoom_fps", "Frames per second while zooming in" + note, "frames per second", kFps,
               bands),
          plot("zoom_ms", "Frame time while zooming in" + note, "time per frame (ms)", kMs, bands),
          plot("zoom_pairs", "Tile pairs while zooming in", "pairs (millions)", kPairs, false)};
}

}  // namespace qs
