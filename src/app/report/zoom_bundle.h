// SPDX-License-Identifier: MIT
//
// A zoom: its inputs and measurements in zoom.json, its plots, and its recording.
// `quadsplat zoom --replay DIR` reads zoom.json, renders the same steps and compares the counts,
// which do not depend on the machine. The plots show FPS, milliseconds and pairs against the zoom,
// one curve per mode. Times are medians, with a bar for the middle half of the frames, if there are
// enough frames for one, and a ring where they are noisy. `quadsplat zoom` and the viewer's
// recorder measure the steps and write the folder of results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/measure/measure_view.h"
#include "app/report/bench_report.h"
#include "app/report/plot.h"
#include "app/session/session.h"

namespace qs {

struct ZoomBundle {
  std::filesystem::path scene;
  std::string scene_hash;
  Camera start;
  glm::dvec3 target{0.0};
  int steps = 32;
  double closest = 0.05;  ///< last distance to the target / first distance
  std::vector<CullMode> modes;
  RenderSettings settings;
  nlohmann::ordered_json altered;  ///< Alterations::json()
  nlohmann::ordered_json environment;
  std::vector<BenchRow> rows = {};  ///< steps x modes; `camera` and `view`: the number of the step
};

/// "noisy_steps" is noisy_steps() of the rows: it is written but not parsed.
std::string format_zoom_json(const ZoomBundle& bundle);

/// Throws Error(input) naming the file.
ZoomBundle read_zoom_json(const std::filesystem::path& path);

/// One sentence per (step, mode) whose pairs or visible Gaussians differ from the bundle's.
std::vector<std::string> count_differences(const std::vector<BenchRow>& recorded,
                                           const std::vector<BenchRow>& replayed);

inline constexpr std::uint64_t kFewestBarFrames = 5;  ///< a point with fewer frames has no bar

/// The smallest number of frames behind a row; 0 if it is unknown or there are no rows.
std::uint64_t frames_per_point(const std::vector<BenchRow>& rows);

/// True if every row has at least kFewestBarFrames frames. False without rows.
bool has_bars(const std::vector<BenchRow>& rows);

/// The quartiles of the frame times, ms. Reports of earlier versions lack the frames: there it is
/// the median and its spread_ms() on both sides.
struct MiddleHalf {
  double low, high;  ///< > 0 if the median is
};
MiddleHalf middle_half(const BenchRow& row);

/// "plush; 1600 x 1200; NVIDIA H200; pipeline fast". `has_times`: adds "; medians of 20 frames".
std::string zoom_caption(const ZoomBundle& bundle, bool has_times);

/// The zoom of a row: first distance to the target / distance, >= 1. `steps` >= 2.
double zoom_factor(const BenchRow& row, int steps, double closest);

/// A mark of an axis.
struct AxisTick {
  double value;
  std::string text;
};

/// The ticks of the zoom's axis, which is logarithmic from 1 to `most` > 1: 1x, 2x, 5x, 10x, 20x.
/// An axis that ends below 2 has ticks at round distances: 1x, 1.05x, 1.1x.
std::vector<AxisTick> zoom_ticks(double most);

/// At least two ticks of an axis from 0: round numbers, 1, 2 or 5 times a power of ten apart. The
/// last tick is the first that is not below `most` > 0.
std::vector<AxisTick> round_ticks(double most);

std::vector<Plot> zoom_plots(const ZoomBundle& bundle);

/// A bundle for this scene and these settings, without rows. Throws Error(input).
ZoomBundle start_zoom(const Session& session, const Camera& start, glm::dvec3 target);

/// Measures one step of the path, `step` < bundle.steps. Returns a row per mode. Throws Cancelled.
std::vector<BenchRow> measure_zoom_step(Session& session, const ZoomBundle& bundle,
                                        std::size_t step, const ViewPlan& plan,
                                        const Progress& progress);

/// Measures all steps. Throws Cancelled.
std::vector<BenchRow> record_zoom(Session& session, const ZoomBundle& bundle, const ViewPlan& plan,
                                  const Progress& progress);

/// Writes zoom.csv, zoom.json, plots, and, while the session has its scene, pictures of the first,
/// middle and last step. Creates the folder. Returns one sentence if the plots could not be drawn,
/// else "".
std::string save_zoom(Session& session, const ZoomBundle& bundle,
                      const std::filesystem::path& folder);

}  // namespace qs
