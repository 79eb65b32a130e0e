// SPDX-License-Identifier: MIT
//
// The zoom recorder: the words of its panel, its part of the window's state for tests, and its
// actions: its plan, its chart and the reports of its jobs. The jobs are in commands/jobs.h.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "app/viewer/state/action.h"
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

/// The work that runs: "recording a zoom, step 5 of 12, about 40 s left", "filming, 31 %"; empty:
/// none.
std::string running_text(const Viewer& viewer);

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

namespace action {

// ---- the plan ----------------------------------------------------------------------------------
void change_zoom_plan(Viewer& viewer, const ZoomPlan& plan);
/// Sets parts of the plan from words: "steps=3 frames=20 closer=8 modes=3dgs,exact size=640x480".
/// "size=window" is the size of the picture in the window. Throws Error(usage).
void choose_zoom(Viewer& viewer, const std::string& words);
/// Remembers the view in the window as the start; forget_zoom_start(): the start is the view in the
/// window when the recording begins.
void start_zoom_here(Viewer& viewer);
void forget_zoom_start(Viewer& viewer);

// ---- the chart ---------------------------------------------------------------------------------
/// `index`: of ZoomRecorder::records. No effect while a zoom is recorded or without such a record.
void show_zoom(Viewer& viewer, std::size_t index);
/// Draws a recording dashed under the other, or no longer if it is drawn so already.
void lay_zoom_beneath(Viewer& viewer, std::size_t index);
void show_zoom_quantity(Viewer& viewer, ZoomQuantity quantity);
/// Copies the plot of the shown quantity to the clipboard, or else its path.
void copy_zoom_figure(Viewer& viewer, Host& host);
void open_zoom_folder(Viewer& viewer, Host& host);

// ---- reports of the jobs -----------------------------------------------------------------------
/// The job is over, also if it did not begin a recording.
void zoom_job_ended(Viewer& viewer);
/// `record` has no rows yet.
void zoom_began(Viewer& viewer, const ZoomRecord& record);
void zoom_stepped(Viewer& viewer, const std::vector<BenchRow>& rows_of_step);
/// `folder`: empty if nothing was saved. A recording that is not saved yet gets its folder later.
void zoom_ended(Viewer& viewer, const std::filesystem::path& folder, bool has_figures);
/// The end of the path is at the distance of the view that was chosen as the end.
void zoom_end_found(Viewer& viewer, double closer);
/// Earlier recordings, oldest first. Recordings that are in the list already are dropped.
void zooms_found(Viewer& viewer, const std::vector<ZoomRecord>& records);

}  // namespace action
}  // namespace qs
