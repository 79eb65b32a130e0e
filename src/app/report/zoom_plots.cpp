// SPDX-License-Identifier: MIT
#include "app/report/zoom_plots.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace qs {
namespace {

// Columns of a mode's data block.
enum Column { kZoom = 1, kFps, kFpsLow, kFpsHigh, kMs, kMsLow, kMsHigh, kPairs };

std::string blocks(const ZoomBundle& bundle) {
  std::string text;
  for (std::size_t m = 0; m < bundle.modes.size(); ++m) {
    std::vector<std::string> lines;
    for (std::size_t i = m; i < bundle.rows.size(); i += bundle.modes.size()) {
      const BenchRow& row = bundle.rows[i];
      const double step = static_cast<double>(row.view) / (bundle.steps - 1);
      lines.push_back(fmt::format("{} {} {} {} {} {} {} {}", std::pow(bundle.closest, -step),
                                  row.fps_median, 1000 / row.ms_p95, 1000 / row.ms_p05,
                                  row.ms_median, row.ms_p05, row.ms_p95,
                                  static_cast<double>(row.pairs) / 1e6));
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

}  // namespace

std::vector<Plot> zoom_plots(const ZoomBundle& bundle) {
  if (bundle.rows.empty()) return {};
  const BenchRow& row = bundle.rows.front();
  const std::string caption = fmt::format("{}; {} x {}; {}", row.scene, row.width, row.height,
                                          measured_on(bundle.environment)) +
                              pipeline_note(bundle.rows);
  const std::string axes = fmt::format(
      "set logscale x 2\nset yrange [0:*]\nset xrange [1:{}]\n"
      "set xlabel \"zoom (first distance to the target / distance)\"\n",
      1 / bundle.closest);
  const auto plot = [&](const char* name, const char* title, const char* label, int column,
                        bool band) {
    return Plot{name, title, caption,
                blocks(bundle) + axes + fmt::format("set ylabel {}\n", quoted(label)) +
                    curves(bundle, column, band)};
  };
  return {plot("zoom_fps", "Frames per second while zooming in (band: 5-95 % of the frames)",
               "frames per second", kFps, true),
          plot("zoom_ms", "Frame time while zooming in (band: 5-95 % of the frames)",
               "time per frame (ms)", kMs, true),
          plot("zoom_pairs", "Tile pairs while zooming in", "pairs (millions)", kPairs, false)};
}

}  // namespace qs
