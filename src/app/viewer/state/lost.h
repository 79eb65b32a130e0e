// SPDX-License-Identifier: MIT
//
// The way back for a user who has lost the scene: a view that shows next to nothing has an arrow to
// the scene's subject.
#pragma once

#include <optional>

#include "app/viewer/state/viewer.h"

namespace qs {

/// The words at the arrow; a test compares their keys with the table of commands.
inline constexpr const char* kWayBack = "Home: first view, Backspace: back";

/// An arrow in the picture, in pixels of Viewer::camera: x to the right, y down.
struct WayToSubject {
  glm::dvec2 direction{1, 0};  ///< unit vector
  glm::dvec2 tip{0.0};  ///< near the picture's edge, or at the subject if it is in the picture
};

/// True if the camera rests and the window shows less than 1 % of the Gaussians. A close view of a
/// large scene may show as few, but fills its tiles with them: then it is false.
bool is_lost(const Viewer& viewer);

/// The arrow to the target of the scene's framing; unset unless the user is lost. The arrow to a
/// subject behind the camera points to the side of the shorter turn.
std::optional<WayToSubject> way_to_subject(const Viewer& viewer);

}  // namespace qs
