// SPDX-License-Identifier: MIT
//
// Actions of the panel "Crop and clean", its words, and the mathematics of the box's handles.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/viewer/state/action.h"

namespace qs {

/// The view of the scene that the window should show now. While the panel is open, Gaussians that
/// are selected or wished away are counted and tinted. During training it is the whole scene.
CropRequest wanted_crop(const Viewer& viewer);

/// The initial box for the user: the scene's subject and a quarter of its size on all sides, or
/// less if `eye` would be inside.
CropBox first_box(const ViewedScene& scene, glm::dvec3 eye);

/// "3 of 500 Gaussians would go: 3 outside of the box", edits_text(), or an instruction.
std::string crop_text(const Viewer& viewer);

/// A handle is in the middle of a face of the box: face 0..5 is low x, high x, low y, ...
inline constexpr int kBoxFaces = 6;
glm::dvec3 handle_of(const CropBox& box, int face);

/// A line in the picture, in pixels.
struct PictureLine {
  glm::dvec2 from{0.0}, to{0.0};
};

/// The part of a line between two points of the world that is in front of the near plane.
std::optional<PictureLine> line_in_picture(const Camera& camera, glm::dvec3 from, glm::dvec3 to);

/// The edges of the box, and its handle of a face; unset if it is behind the near plane.
std::vector<PictureLine> box_lines(const Camera& camera, const CropBox& box);
std::optional<glm::dvec2> handle_in_picture(const Camera& camera, const CropBox& box, int face);

/// The box with a face at the place on its axis that is nearest to the ray through `pixel`, but no
/// farther than the opposite face. Empty if the ray is parallel to the axis or that place is behind
/// the camera.
std::optional<CropBox> dragged(const CropBox& box, int face, const Camera& camera,
                               glm::dvec2 pixel);

/// The distance from `point` along `direction`, a unit vector, of the point that is nearest to the
/// ray through `pixel`, world units. Empty if they are parallel or the ray's nearest point is
/// behind the camera.
std::optional<double> slide_along(const Camera& camera, glm::dvec3 point, glm::dvec3 direction,
                                  glm::dvec2 pixel);

/// The window shows the scene with these edits now, so many Gaussians.
void show_edits(Viewer& viewer, const EditFacts& edits, std::uint64_t gaussians);

namespace action {

/// Changes the criteria. They refer to the scene as it is edited. A face of the box cannot pass the
/// opposite face.
void change_crop(Viewer& viewer, const CropWish& wish);
/// Sets the criteria from words: X0,Y0,Z0,X1,Y1,Z1 crops to a box, "floaters" also drops floaters,
/// "nothing" switches both off and shows the whole scene without a way back. Throws Error(usage).
void choose_crop(Viewer& viewer, const std::string& words);
void mark_removed(Viewer& viewer, bool marks);
/// Puts the box around the scene's subject.
void fit_crop_box(Viewer& viewer);
/// Moves the camera along its viewing direction so that it shows the whole box.
void show_crop_box(Viewer& viewer);

/// Removes the Gaussians that the criteria take, as steps of the edits.
void apply_crop(Viewer& viewer);
/// The same; without criteria it takes the last change back.
void toggle_crop(Viewer& viewer);

// ---- reports of the render thread --------------------------------------------------------------
void crop_shown(Viewer& viewer, const CropRequest& request, const ShownCrop& shown);
void crop_failed(Viewer& viewer, const std::string& sentence);

}  // namespace action
}  // namespace qs
