// SPDX-License-Identifier: MIT
//
// Records a zoom: measures the steps along its path and writes the folder of results. Used by
// `quadsplat zoom` and the viewer's recorder.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "app/measure/measure_view.h"
#include "app/report/zoom_bundle.h"

namespace qs {

/// A bundle for this scene and these settings, without rows. Throws Error(input).
ZoomBundle start_zoom(const Session& session, const Camera& start, glm::dvec3 target);

/// Measures one step of the path, `step` < bundle.steps. Returns a row per mode. Throws Cancelled.
std::vector<BenchRow> measure_zoom_step(Session& session, const ZoomBundle& bundle,
                                        std::size_t step, const ViewPlan& plan,
                                        const Progress& progress);

/// Measures all steps. Throws Cancelled.
std::vector<BenchRow> record_zoom(Session& session, const ZoomBundle& bundle, const ViewPlan& plan,
                                  const Progress& progress);

/// Writes zoom.csv, zoom.json, plots, and pictures of the first, middle and last step. Creates the
/// folder. Returns one sentence if the plots could not be drawn, else "".
std::string save_zoom(Session& session, const ZoomBundle& bundle,
                      const std::filesystem::path& folder);

}  // namespace qs
