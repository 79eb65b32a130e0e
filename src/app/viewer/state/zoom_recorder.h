// SPDX-License-Identifier: MIT
//
// The zoom recorder's state as plain data: the plan, the recordings and the choice of the chart.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/report/zoom_bundle.h"
#include "app/viewer/state/zoom_plan.h"

namespace qs {

/// A recorded zoom, or the part of it that is measured so far.
struct ZoomRecord {
  std::filesystem::path folder;  ///< empty until it is saved
  bool has_figures = false;      ///< gnuplot has drawn the plots in `folder`
  std::string scene, machine;    ///< `machine`: measured_on()
  std::string pipeline;          ///< as in reports: "cpu", "classic", "fast"
  int width = 0, height = 0;     ///< pixels
  int steps = 2;                 ///< planned
  double closest = 0.05;         ///< last distance to the target / first distance
  std::vector<CullMode> modes;
  std::vector<BenchRow> rows;  ///< ordered by step, then by mode
};

/// The facts and the rows of a bundle; not saved yet.
ZoomRecord make_zoom_record(const ZoomBundle& bundle);

/// The quantity on the vertical axis of the chart.
enum class ZoomQuantity { fps, ms, pairs };

struct ZoomQuantityRow {
  const char *name, *title;  ///< of the button; above the chart
  const char* figure;        ///< name of the plot's file
};

/// Index = ZoomQuantity.
inline constexpr ZoomQuantityRow kZoomQuantities[] = {
    {"FPS", "frames per second", "zoom_fps.png"},
    {"ms", "milliseconds per frame", "zoom_ms.png"},
    {"pairs", "tile pairs", "zoom_pairs.png"}};

struct ZoomRecorder {
  ZoomPlan plan;
  bool starting = false;  ///< a recording was requested, and its job has not begun or failed yet
  bool running = false;
  bool searched = false;            ///< earlier recordings were searched in the folder of zooms
  std::vector<ZoomRecord> records;  ///< oldest first; while `running` the last one grows
  std::optional<std::size_t> shown, beneath;  ///< of `records`: the chart's curves, dashed curves
  ZoomQuantity quantity = ZoomQuantity::fps;
};

/// The recording in the chart, and the dashed one; null if there is none.
const ZoomRecord* shown_zoom(const ZoomRecorder& zoom);
const ZoomRecord* zoom_beneath(const ZoomRecorder& zoom);

/// Another scene is opened: the remembered start is not of it, and the chart is empty. The
/// recordings stay.
void forget_zoom_views(ZoomRecorder& zoom);

}  // namespace qs
