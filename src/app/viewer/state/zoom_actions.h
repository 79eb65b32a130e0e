// SPDX-License-Identifier: MIT
//
// Actions of the zoom recorder: its plan, its chart and the reports of its jobs. The jobs are in
// commands/jobs.h.
#pragma once

#include "app/viewer/state/action.h"

namespace qs::action {

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
/// Copies the path of the plot of the shown quantity to the clipboard.
void copy_zoom_figure(Viewer& viewer, Host& host);
void open_zoom_folder(Viewer& viewer, Host& host);

// ---- reports of the jobs -----------------------------------------------------------------------
/// The job is over, also if it did not begin a recording.
void zoom_job_ended(Viewer& viewer);
/// `record` has no rows yet.
void zoom_began(Viewer& viewer, const ZoomRecord& record);
void zoom_stepped(Viewer& viewer, const std::vector<BenchRow>& rows_of_step);
/// `folder`: empty if nothing was saved.
void zoom_ended(Viewer& viewer, const std::filesystem::path& folder, bool has_figures);
/// The end of the path is at the distance of the view that was chosen as the end.
void zoom_end_found(Viewer& viewer, double closer);
/// Earlier recordings, oldest first. Recordings that are in the list already are dropped.
void zooms_found(Viewer& viewer, const std::vector<ZoomRecord>& records);

}  // namespace qs::action
