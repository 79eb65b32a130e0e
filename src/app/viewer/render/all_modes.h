// SPDX-License-Identifier: MIT
//
// All modes of a view: side by side, in colours or with a heat map of one scale, and measured off
// screen for the table of modes.
#pragma once

#include <chrono>
#include <optional>

#include "app/viewer/render/render_context.h"

namespace qs {

/// The picture of one mode in the grid.
struct ModePicture {
  CullMode mode = 0;
  Image image;  ///< RGB, with the map over it if there is one
  RenderStats stats;
  std::optional<Heatmap> heatmap;
};

/// Draws the view of the request in every mode, from mode 1 on, and calls visit(picture) for each,
/// so that only one full-size picture is kept. `camera`: the request's, at the size to draw;
/// `scale`: of its heat maps. Throws Error and Cancelled.
void draw_all_modes(RenderContext& context, const FrameRequest& request, const Camera& camera,
                    const Scale& scale, const std::function<void(ModePicture)>& visit);

/// The frame of the window: the pictures in small at their places.
RenderedFrame draw_grid(RenderContext& context, const FrameRequest& request, const Camera& camera);

struct NumbersRequest {
  Camera camera;
  RenderSettings settings;
  int version = 0;    ///< Viewer::view_version
  bool more = false;  ///< adds frames to the numbers of this view
};

/// Reports frame_paired() for the first frame of each mode, then numbers_measured(), or
/// numbers_refined() for `more`. A measurement that fails is reported without rows, so that it is
/// not repeated. Throws Error and Cancelled.
void measure_modes(RenderContext& context, const NumbersRequest& request);

/// Draws frames of other modes at the view and size of pictures of a moving camera, one mode after
/// the other, and reports frame_paired(). They take less than a fifth of the time of the CPU and a
/// twentieth of a GPU's, so that the flight stays smooth. After a switch the mode before comes
/// first.
class PairedFrames {
 public:
  /// Call it after each picture was drawn and shown. `camera`: at its size.
  void follow(RenderContext& context, const FrameRequest& request, const Camera& camera,
              const RenderStats& shown);

 private:
  CullMode next_in_turn();

  std::optional<std::chrono::steady_clock::time_point> now_;
  double credit_ = 0, cost_ = 0;  // milliseconds
  CullMode last_ = 0, shown_ = 0;
};

}  // namespace qs
