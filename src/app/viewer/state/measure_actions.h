// SPDX-License-Identifier: MIT
//
// Measuring with points of surfaces, and the cross that keys move over the picture for its tools.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/viewer/state/action.h"

namespace qs {

/// A leg of a ruler between two points of the world, and which of its kRulerParts equal parts are
/// behind a surface; empty: not known for this view.
struct Ruler {
  SurfacePoint from, to;
  std::vector<bool> hidden = {};
  std::string text;  ///< its length
};
std::vector<Ruler> rulers_of(const Viewer& viewer);

/// The measured points with their numbers from 1 on, distances, angles and dimensions. Heights of
/// points are above the ground, heights of distances along the scene's up.
std::vector<MeasureRow> rows_of_measures(const Viewer& viewer);

/// A scale from the last two points and the typed length: "1 unit = 0.31 ± 0.01 m".
std::string scale_preview(const Viewer& viewer);

/// SCENE.measures.json beside the scene: the window writes it after each change, and reads it with
/// the scene.
std::filesystem::path kept_measures_file(const std::filesystem::path& scene);
/// True if that file is to be written because it has other measures.
bool measures_are_to_keep(const Viewer& viewer);
/// True if no file has the measures, and none will be written by itself.
bool measures_are_unsaved(const Viewer& viewer);

namespace action {

/// Opens the panel, and clicks set points; or closes it.
void toggle_measuring(Viewer& viewer);
void pick_points(Viewer& viewer, bool picks);
/// The next pixel shows the last point again.
void pick_again(Viewer& viewer, bool again);

/// Looks for the surface at a pixel of the picture, which becomes the next point; or, if the user
/// said so, the last point is where this line of sight crosses its own.
void measure_pixel(Viewer& viewer, Host& host, glm::dvec2 pixel);
/// The next point begins a new line.
void end_line(Viewer& viewer);
void remove_last_point(Viewer& viewer);
void clear_measures(Viewer& viewer);
/// Copies the measures as a table with tabs.
void copy_measures(Viewer& viewer, Host& host);

/// The last two points have the typed length.
void set_scale(Viewer& viewer);
/// The last three points are on the ground, which is level: the scene's up changes.
void set_ground(Viewer& viewer);
/// Measures the box of the selected Gaussians.
void measure_selection(Viewer& viewer, Host& host);

/// Writes a file of measures, then runs an action, which may be null.
void save_measures(Viewer& viewer, Host& host, const Action& then);
/// Replaces the measures by the measures of a file.
void open_measures(Viewer& viewer, Host& host, const std::filesystem::path& file,
                   const std::optional<std::string>& text = {});
/// Reads the file beside the scene, if there is one.
void restore_measures(Viewer& viewer, Host& host);
/// Writes the file beside the scene, then runs an action, which may be null.
void keep_measures(Viewer& viewer, Host& host, const Action& then);

/// Keeps the measures beside the scene, and looks which parts of the rulers surfaces hide, once the
/// view rests.
void follow_measures(Viewer& viewer, Host& host);

/// Moves the cross, which begins in the middle of the picture, by pixels. Without a tool the view
/// turns, as by drags of 10 times as many pixels the other way.
void move_cross(Viewer& viewer, glm::dvec2 by);

// ---- reports of the render thread --------------------------------------------------------------
/// `point`: unset if the pixel shows no surface. `hidden`: empty if it was cancelled.
void point_measured(Viewer& viewer, const std::optional<SurfacePoint>& point);
void rulers_hidden(Viewer& viewer, int view_version, const std::vector<std::vector<bool>>& hidden);
void measures_opened(Viewer& viewer, const std::filesystem::path& file, const Measures& measures);
/// Beside the scene; `problem`: a sentence if they could not be, or "".
void measures_kept(Viewer& viewer, const std::string& problem);
void box_measured(Viewer& viewer, const MeasuredBox& box);

}  // namespace action
}  // namespace qs
