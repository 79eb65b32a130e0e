// SPDX-License-Identifier: MIT
//
// The words of the panel "Zoom recorder", and its part of the window's state for tests.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "app/viewer/state/viewer.h"

namespace qs {

/// Seconds of frames that the plan takes: the times of the modes in the table, else the time of the
/// frame in the window, by the number of pixels. Frames near the target may take longer. Unset if
/// no time is known.
std::optional<double> zoom_seconds(const Viewer& viewer);

/// Seconds until the running recording ends, from the steps so far; unset before the first step.
std::optional<double> zoom_seconds_left(const ZoomRecorder& zoom);

/// "about 40 s", "about 3 min": rounded up.
std::string about_text(double seconds);

/// The begin of a recording: "from this view".
const char* zoom_start_text(const ZoomPlan& plan);

/// "12 steps of 6 modes: about 40 s".
std::string zoom_plan_text(const Viewer& viewer);

/// The steps so far while a zoom is recorded, else the place of the recording in the chart.
std::string zoom_status(const ZoomRecorder& zoom);

/// The name of a recording, its pipeline, size and machine.
std::string zoom_label(const ZoomRecord& record);

/// The recording's name alone: "plush_0003", or the scene until it is saved.
std::string zoom_title(const ZoomRecord& record);

/// "medians of 20 frames, band: 5-95 % of them", and the noisy steps.
std::string zoom_trust_text(const ZoomRecord& record);

/// The recorder in state_json().
nlohmann::ordered_json zoom_json(const Viewer& viewer);

}  // namespace qs
