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

// ---- motion that takes time --------------------------------------------------------------------
/// Flies until the next turn. `direction`: right, down, forward, each -1..1; `factor` multiplies
/// the speed. The camera accelerates, and slows down when fly() is no longer called.
void fly(Viewer& viewer, glm::dvec3 direction, double factor);

/// The wheel: nearer or farther in orbit mode, faster or slower in fly mode.
void turn_wheel(Viewer& viewer, double notches);

/// Moves to a view of any size within a moment, or immediately if moves are not animated.
/// `dataset_camera`: the index of the camera of the data set with this view, else -1.
void travel_to(Viewer& viewer, const Camera& camera, int dataset_camera = -1);

/// Ends a travel immediately.
void arrive(Viewer& viewer);

/// Advances flight or travel by `seconds`.
void advance_motion(Viewer& viewer, double seconds);

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

/// The direction `up`, a unit vector, is up in the world, now and whenever this scene is opened.
void declare_up(Viewer& viewer, glm::dvec3 up);
/// The view's vertical axis becomes the world's, now and whenever this scene is opened.
void make_upright(Viewer& viewer);

/// Sets camera, home and pivot to the first camera of the scene's data set, else to the first view
/// that was chosen for this scene, else to the framed scene.
void set_first_view(Viewer& viewer, Host& host);

/// Reads the photograph of the current camera of the data set, if photographs are shown.
void read_photograph(Viewer& viewer, Host& host);

// ---- choosing the first view of a scene without cameras from pictures of a few candidates ------
/// Shows the strip of candidates as soon as the scene and then their pictures are drawn. No effect
/// if the scene has cameras or fewer than two candidates.
void offer_views(Viewer& viewer);

/// The same for the user who asks for it: says why there is no choice.
void ask_for_views(Viewer& viewer);

/// The pictures of the candidates of this scene file; ignored if nobody waits for them.
void candidates_drawn(Viewer& viewer, const std::filesystem::path& scene,
                      const std::shared_ptr<const Image>& pictures);

/// Goes to a candidate, which is the scene's first view from now on, and closes the strip. `index`
/// into ViewedScene::candidates.
void choose_first_view(Viewer& viewer, Host& host, std::size_t index);

void close_view_choice(Viewer& viewer);

// ---- bookmarks of the scene in the window; `index` into bookmarks_of() -------------------------
/// Keeps this view as "view 3", and opens the panel where it can be renamed.
void keep_bookmark(Viewer& viewer);
void name_bookmark(Viewer& viewer, std::size_t index, const std::string& name);
void remove_bookmark(Viewer& viewer, std::size_t index);
void go_to_bookmark(Viewer& viewer, std::size_t index);

// ---- turning a scene upright: its file is read as if its axes were others ----------------------
/// Reads the scene's file with the next frame of axes, and remembers the frame for this file. After
/// the last frame come the axes that the file declares.
void next_axes(Viewer& viewer, Host& host);

/// Reads the scene's file turned by 180 degrees about the view's right axis, and remembers that for
/// this file. A second call turns it back.
void turn_over(Viewer& viewer, Host& host);

}  // namespace qs::action

namespace qs {

/// The speed of flying, world units per second. It is proportional to the distance of the scene in
/// front, times the factor that the wheel sets.
double flying_speed(const Viewer& viewer);

/// True if the preferences know neither a last view nor a chosen first view of this scene.
bool is_unknown(const Viewer& viewer, const ViewedScene& scene);

/// The bookmarks of the scene in the window.
const Bookmarks& bookmarks_of(const Viewer& viewer);

/// The up direction that make_upright() remembered for this scene file.
std::optional<glm::dvec3> remembered_up(const Viewer& viewer, const std::filesystem::path& scene);

/// The view in which the user left this scene file, of any size; unset if views are not restored.
std::optional<Camera> last_view(const Viewer& viewer, const std::filesystem::path& scene);

/// The view at the window's size in which scene_opened() shows another scene.
Camera opening_view(const Viewer& viewer, const ViewedScene& scene);

/// The axes that were chosen for this scene file; "" if no axes were chosen.
std::string remembered_axes(const Viewer& viewer, const std::filesystem::path& scene);

}  // namespace qs
