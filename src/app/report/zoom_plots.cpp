// SPDX-License-Identifier: MIT
#include "app/report/zoom_plots.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/picture/palette.h"

namespace qs {
namespace {

// Columns of a mode's block.
enum Column { kZoom = 1, kFps, kFpsLow, kFpsHigh, kMs, kMsLow, kMsHigh, kPairs };

std::string blocks(const ZoomBundle& bundle) {
  std::string text;
  for (std::size_t m = 0; m < bundle.modes.size(); ++m) {
    text += fmt::format("$mode{} << END\n", m);
    for (std::size_t i = m; i < bundle.rows.size(); i += bundle.modes.size()) {
      const BenchRow& row = bundle.rows[i];
      const double step = static_cast<double>(row.view) / (bundle.steps - 1);
      text += fmt::format("{} {} {} {} {} {} {} {}\n", std::pow(bundle.closest, -step),
                          row.fps_median, 1000 / row.ms_p95, 1000 / row.ms_p05, row.ms_median,
                          row.ms_p05, row.ms_p95, static_cast<double>(row.pairs) / 1e6);
    }
    text += "END\n";
  }
  return text;
}

// Bands first, so that they lie under all curves. quadbox-naive lists the same pairs as quadbox:
// its curve is wider, to be seen under the other.
std::string curves(const ZoomBundle& bundle, int column, bool band) {
  std::string text;
  for (const bool line : {false, true}) {
    for (std::size_t m = 0; m < bundle.modes.size() && (line || band); ++m) {
      const std::string mode = mode_name(bundle.modes[m]);
      text += text.empty() ? "plot " : ", \\\n  ";
      text += line ? fmt::format(
                         "$mode{} using 1:{} with linespoints linewidth {} pointtype {} "
                         "pointsize 1.3 pointinterval {} linecolor rgb {} title {}",
                         m, column, mode == "quadbox-naive" ? 4.0 : 1.8, mode_marker(mode),
                         std::max(1, bundle.steps / 8), quoted(mode_color(mode)), quoted(mode))
                   : fmt::format(
                         "$mode{} using 1:{}:{} with filledcurves linecolor rgb {} "
                         "fillstyle transparent solid 0.2 noborder notitle",
                         m, column + 1, column + 2, quoted(mode_color(mode)));
    }
  }
  return text;
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
