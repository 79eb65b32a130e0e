// SPDX-License-Identifier: MIT
//
// Actions that start a background job: a function job(RenderContext&, const Viewer&, arguments...)
// that runs on the render thread with a copy of the Viewer as it was when the job was started. A
// job reports its outcome with RenderContext::report(); an exception is shown to the user. Jobs
// that only a key or a menu starts are rows of commands.cpp.
#pragma once

#include "app/viewer/state/action.h"

namespace qs {

template <class Function, class... Arguments>
void start_job(const Viewer& viewer, Host& host, Function function, Arguments... arguments) {
  host.run([=](RenderContext& context) { function(context, viewer, arguments...); });
}

/// The same for a job that calls RenderContext::give_way between its parts.
template <class Function>
void start_long_job(const Viewer& viewer, Host& host, Function function) {
  host.run_long([=](RenderContext& context) { function(context, viewer); });
}

namespace action {

/// Sets the pivot to the point that a pixel shows.
void pick_pivot(Viewer& viewer, Host& host, glm::dvec2 pixel);

/// Inspects a pixel of the picture; no effect while the inspector is closed.
void inspect_pixel(Viewer& viewer, Host& host, glm::dvec2 pixel);

/// Picks another Gaussian of the inspected pixel, by its index in the cloud.
void inspect_gaussian(Viewer& viewer, Host& host, std::uint32_t gaussian);

/// Uploads the scene to another backend and shows it from there.
void change_backend(Viewer& viewer, Host& host, Backend backend);

/// Closes the second scene and the split, or opens the dialog to choose a second scene.
void toggle_beside(Viewer& viewer, Host& host);

/// Records a zoom by the plan, or stops the recording.
void toggle_zoom_recording(Viewer& viewer, Host& host);

/// Ends the planned zoom at the distance of this view from the target. The start must be
/// remembered.
void end_zoom_here(Viewer& viewer, Host& host);

/// Lists the recordings of earlier sessions. No effect after the first call.
void find_zooms(Viewer& viewer, Host& host);

/// Films the path, or a turntable if there is no path. A split window makes a split film.
void film(Viewer& viewer, Host& host);

/// Writes the rest of a cropped scene to a new file, in the format of its extension. A relative
/// `name` is below Viewer::out_dir; an empty name stands for SCENE_cropped_NNNN.ply. Refuses a file
/// that exists. `then`: after the file was written; may be null.
void save_crop(Viewer& viewer, Host& host, const std::filesystem::path& name, const Action& then);

/// Writes keyframes, measures and a crop to files, and leaves once they are written. For results it
/// asks for a folder, and stays.
void save_and_leave(Viewer& viewer, Host& host, const std::filesystem::path& opens);

}  // namespace action
}  // namespace qs
