// SPDX-License-Identifier: MIT
//
// Records a zoom: the measurements along its path, and the folder they are kept in. `quadsplat
// zoom` and the viewer's recorder both do it here.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "app/measure/measure_view.h"
#include "app/report/zoom_bundle.h"

namespace qs {

/// A bundle without rows for this scene and these settings. Throws Error(input).
ZoomBundle start_zoom(const Session& session, const Camera& start, glm::dvec3 target);

/// Measures every step; `on_step(camera, rows of the step)` follows the recording. Throws
/// Cancelled.
std::vector<BenchRow> record_zoom(
    Session& session, const ZoomBundle& bundle, const ViewPlan& plan, const Progress& progress,
    const std::function<void(const Camera&, const std::vector<BenchRow>&)>& on_step = {});

/// zoom.csv, zoom.json, plots, pictures of the first, middle and last step. Makes the folder.
/// Returns one sentence when the plots could not be drawn, else "".
std::string save_zoom(Session& session, const ZoomBundle& bundle,
                      const std::filesystem::path& folder);

}  // namespace qs
