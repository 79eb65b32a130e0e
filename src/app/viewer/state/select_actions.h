// SPDX-License-Identifier: MIT
//
// Selecting Gaussians in the picture. Each selection is a step of the edits (edit_actions.h).
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

/// The step of a tool that was drawn: its result replaces the selection as `how` says.
SelectStep drawn_step(const Viewer& viewer);

namespace action {

/// `tool`: one of kPictureTools; unset: drags move the camera again.
void choose_tool(Viewer& viewer, const std::optional<SelectTool>& tool);
void next_tool(Viewer& viewer);
void scale_brush(Viewer& viewer, float factor);

/// A press, a move and a release of the left button at a pixel of the picture, while a tool is
/// chosen. The release selects.
void begin_shape(Viewer& viewer, glm::dvec2 pixel, SelectHow how);
void extend_shape(Viewer& viewer, glm::dvec2 pixel);
void end_shape(Viewer& viewer);
/// Selects by the shape, as Enter does; a message if it has too few points.
void close_shape(Viewer& viewer);
/// Uses the pixel of the cross as a click does; a second time at the same place closes the shape or
/// the line.
void use_cross(Viewer& viewer, Host& host);
/// The same for a tool that selects and a new place.
void use_cross_to_select(Viewer& viewer);
/// Gives up the shape, else the tool.
void cancel_tool(Viewer& viewer);

/// By opacity or size, or by the distance from the last measured point.
void select_by_value(Viewer& viewer, SelectTool tool);
/// Selects by a step without a picture: all, none, invert, grow, shrink, flood.
void select_by(Viewer& viewer, SelectTool tool);

}  // namespace action
}  // namespace qs
