// SPDX-License-Identifier: MIT
//
// Selecting Gaussians in the picture. A selection is a criterion of the crop (CropWish::selected):
// it is tinted, counted, applied and undone as boxes and floaters are.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "app/viewer/state/action.h"
#include "app/viewer/state/crop_actions.h"
#include "raster/select/edit_step.h"

namespace qs {

/// The outline of the shape that is being drawn, and of the brush at the cursor.
std::vector<PictureLine> shape_lines(const Viewer& viewer);

/// The selected Gaussians of the scene in the window; null: none.
std::shared_ptr<const GaussianSet> selection_of(const Viewer& viewer);

/// The step of a tool that was drawn: its result replaces the selection as `how` says.
SelectStep drawn_step(const Viewer& viewer);

namespace action {

/// `tool`: one of kPictureTools; unset: drags move the camera again.
void choose_tool(Viewer& viewer, const std::optional<SelectTool>& tool);
void next_tool(Viewer& viewer);
void scale_brush(Viewer& viewer, float factor);

/// A press, a move and a release of the left button at a pixel of the picture, while a tool is
/// chosen. The release runs the selection.
void begin_shape(Viewer& viewer, glm::dvec2 pixel, SelectHow how);
void extend_shape(Viewer& viewer, glm::dvec2 pixel);
void end_shape(Viewer& viewer, Host& host);
/// Uses the pixel of the cross as a click does; a second time at the same place closes the shape or
/// the line.
void use_cross(Viewer& viewer, Host& host);
/// Gives up the shape, else the tool.
void cancel_tool(Viewer& viewer);

/// Selects by a step without a picture: all, none, invert, grow, shrink, flood.
void select_by(Viewer& viewer, Host& host, SelectTool tool);

/// Writes a file of edits with the crops that were applied and the selection.
void save_edits(Viewer& viewer, Host& host);

// ---- reports of the render thread --------------------------------------------------------------
/// `set`: of the scene in the window, not null.
void gaussians_selected(Viewer& viewer, const std::shared_ptr<const GaussianSet>& set);
void selecting_failed(Viewer& viewer, const std::string& sentence);
void edits_saved(Viewer& viewer);

}  // namespace action
}  // namespace qs
