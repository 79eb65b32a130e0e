// SPDX-License-Identifier: MIT
//
// zoom.json: the inputs of a zoom and the measurements. `quadsplat zoom --replay DIR` reads it,
// renders the same steps and compares the counts, which do not depend on the machine.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/report/bench_report.h"
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
  nlohmann::ordered_json environment;
  std::vector<BenchRow> rows;  ///< steps x modes; `camera` and `view` are the number of the step
};

/// "noisy_steps" is noisy_steps() of the rows: it is written but not parsed.
std::string format_zoom_json(const ZoomBundle& bundle);

/// Throws Error(input) naming the file.
ZoomBundle read_zoom_json(const std::filesystem::path& path);

/// One sentence per (step, mode) whose pairs or visible Gaussians differ from the bundle's.
std::vector<std::string> count_differences(const std::vector<BenchRow>& recorded,
                                           const std::vector<BenchRow>& replayed);

}  // namespace qs
