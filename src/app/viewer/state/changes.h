// SPDX-License-Identifier: MIT
//
// Changes of the viewer that several actions have in common.
#pragma once

#include <string>

#include "app/viewer/state/actions.h"

namespace qs {

/// Something else is to be drawn; view_changed(): and measured, and judged by the reference.
void picture_changed(Viewer& viewer);
void view_changed(Viewer& viewer);

/// A sentence for a while.
void say(Viewer& viewer, std::string text, bool error = false);

void request_now(Viewer& viewer, Request request);

/// The camera, wherever it came from, at the window's size.
void set_view(Viewer& viewer, const Camera& camera);

/// The camera as it is, on its way: no longer one of the data set's.
void move(Viewer& viewer, const Camera& camera);

/// Where the camera turns around when nothing was picked: on its line of sight, beside the scene's
/// middle.
glm::dvec3 natural_pivot(const Camera& camera, const ViewedScene& scene);

/// In front of the camera, > 0, world units.
double pivot_depth(const Viewer& viewer);

/// A view of the whole scene, which must be there.
Camera framed(const Viewer& viewer);

/// The view of a scene that was just opened: its first data set camera, else framed. Sets camera,
/// home and pivot.
void set_first_view(Viewer& viewer);

/// To a camera of the scene; nothing happens when there is no such one.
void go_to_camera(Viewer& viewer, int index);
void step_camera(Viewer& viewer, action::CameraStep step);

/// Requests the photograph of the camera that the view stands at, when they are shown.
void read_photograph(Viewer& viewer);

}  // namespace qs
