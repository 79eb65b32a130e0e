// SPDX-License-Identifier: MIT
//
// Actions that move the camera, and the views that it can return to.
#pragma once

#include "app/viewer/state/action.h"

namespace qs::action {

// ---- motion: pixels of the cursor, notches of the wheel ----------------------------------------
void orbit(Viewer& viewer, glm::dvec2 pixels);
void look(Viewer& viewer, glm::dvec2 pixels);
void pan(Viewer& viewer, glm::dvec2 pixels);
void dolly(Viewer& viewer, double notches);
void change_fov(Viewer& viewer, double notches);
void roll(Viewer& viewer, double notches);

/// Moves camera and pivot by a step in view axes (right, down, forward), world units.
void shift(Viewer& viewer, glm::dvec3 step);

/// Sets the camera after a motion: the view no longer counts as one of the data set's cameras.
void move(Viewer& viewer, const Camera& camera);

// ---- views -------------------------------------------------------------------------------------
/// Fits a camera of any size to the window.
void set_camera(Viewer& viewer, const Camera& camera);
/// Turns to a point, goes half the way to it, and orbits around it from now on.
void frame_point(Viewer& viewer, glm::dvec3 point);
void resize(Viewer& viewer, int width, int height);
void frame_scene(Viewer& viewer);

/// Goes to a camera of the data set, with its photograph if photographs are shown. No effect
/// without that camera.
void go_to_camera(Viewer& viewer, Host& host, int index);
enum class CameraStep { previous, next, first, last, nearest };
void step_camera(Viewer& viewer, Host& host, CameraStep step);
void go_home(Viewer& viewer, Host& host);

/// Keeps the view in Viewer::history if it differs from the view there. Called at the end of every
/// move; no effect while the camera travels.
void complete_move(Viewer& viewer);
/// Goes back to the view before the last move, and forward again.
void undo_move(Viewer& viewer, Host& host);
void redo_move(Viewer& viewer, Host& host);

/// The view's vertical axis becomes the world's, now and whenever this scene is opened.
void make_upright(Viewer& viewer);

/// Sets camera, home and pivot to the first camera of the scene's data set, else to the first view
/// that was chosen for this scene, else to the framed scene.
void set_first_view(Viewer& viewer, Host& host);

/// Reads the photograph of the current camera of the data set, if photographs are shown.
void read_photograph(Viewer& viewer, Host& host);

}  // namespace qs::action

namespace qs {

/// The up direction that make_upright() remembered for this scene file.
std::optional<glm::dvec3> remembered_up(const Viewer& viewer, const std::filesystem::path& scene);

/// The view in which the user left this scene file, of any size; unset if views are not restored.
std::optional<Camera> last_view(const Viewer& viewer, const std::filesystem::path& scene);

/// The first view that the user chose for this scene file, of any size.
std::optional<Camera> chosen_first_view(const Viewer& viewer, const std::filesystem::path& scene);

/// The view at the window's size in which scene_opened() shows another scene.
Camera opening_view(const Viewer& viewer, const ViewedScene& scene);

/// The axes that were chosen for this scene file; "" if no axes were chosen.
std::string remembered_axes(const Viewer& viewer, const std::filesystem::path& scene);

}  // namespace qs
