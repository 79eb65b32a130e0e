// SPDX-License-Identifier: MIT
//
// The zoom recorder's state as plain data: the plan, the recordings and the choice of the chart.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "app/report/zoom_bundle.h"
#include "raster/api/renderer.h"

namespace qs {

inline constexpr int kFewestZoomSteps = 2, kMostZoomSteps = 200;
inline constexpr int kFewestZoomFrames = 20, kMostZoomFrames = 1000;
inline constexpr int kZoomWarmUp = 3;  ///< untimed frames per mode, before every step
inline constexpr double kLeastCloser = 1.1, kMostCloser = 1000;
inline constexpr int kMostZoomSide = 8192;  ///< pixels

/// The sizes that the panel offers; the first stands for the size of the table of modes.
inline constexpr std::array<glm::ivec2, 4> kZoomSizes = {
    {{0, 0}, {1280, 720}, {1600, 1200}, {1920, 1080}}};

/// The path is zoom_path(): from the start to the point in the middle of its picture.
struct ZoomPlan {
  std::optional<Camera> start;  ///< unset: the view when the recording begins
  double closer = 20;           ///< first distance to the target / last distance
  int steps = 12;
  int frames = kFewestZoomFrames;    ///< timed, per mode and step
  std::vector<CullMode> modes;       ///< sorted; empty: all
  glm::ivec2 size{0};                ///< pixels; 0: as the table of modes
  std::optional<Pipeline> pipeline;  ///< unset: the window's

  bool operator==(const ZoomPlan& other) const;
};

/// The plan with all values in their ranges. Everything that changes a plan goes through here.
ZoomPlan clamped_plan(ZoomPlan plan, Backend backend);

/// The modes that are measured, never empty.
std::vector<CullMode> zoom_modes(const ZoomPlan& plan);

/// The first camera of the path. `view`: the camera of the window, at its size.
Camera zoom_start(const ZoomPlan& plan, const Camera& view);

/// Frames that are rendered per mode and step, untimed ones included.
int zoom_frames(const ZoomPlan& plan, Backend backend);

/// A recorded zoom, or the part of it that is measured so far.
struct ZoomRecord {
  std::filesystem::path folder = {};  ///< empty until it is saved
  bool has_figures = false;           ///< the plots in `folder` are drawn
  std::string scene, machine;         ///< `machine`: measured_on()
  std::string pipeline;               ///< as in reports: "cpu", "classic", "fast"
  int width = 0, height = 0;          ///< pixels
  int steps = 2;                      ///< planned
  double closest = 0.05;              ///< last distance to the target / first distance
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
