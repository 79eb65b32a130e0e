// SPDX-License-Identifier: MIT
//
// The views of a scene that the user can go back to. Every completed move of the camera is a step:
// camera_actions.h has the actions.
#pragma once

#include <cstddef>
#include <deque>

#include "app/framing/first_view.h"

namespace qs {

/// A view at the end of a move, and the state of the viewer that belongs to it.
struct PastView {
  Camera camera;
  glm::dvec3 pivot{0.0};    ///< Viewer::pivot
  int dataset_camera = -1;  ///< Viewer::dataset_camera
};

/// True if two cameras show the same view, perhaps at different sizes.
bool same_view(const Camera& a, const Camera& b);

/// The views that are kept; older views are forgotten.
inline constexpr std::size_t kMostViews = 100;

struct ViewHistory {
  std::deque<PastView> views;  ///< oldest first
  std::size_t at = 0;          ///< index of the view in the window, or on the way to it

  /// Appends a view after the current one, in the place of all later views. A view that equals the
  /// current view replaces it, and the later views stay.
  void keep(const PastView& view);

  /// Steps to the view before or after the current one; null, and no step, if there is none. The
  /// pointer is valid until the next keep().
  const PastView* back();
  const PastView* forward();
};

}  // namespace qs
