// SPDX-License-Identifier: MIT
//
// Crop and clean: the box and the criteria of floaters, the count of Gaussians to remove, Apply,
// Undo and Save as. The box's handles are in overlay.cpp.
#include <imgui.h>
#include <imgui_stdlib.h>

#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"

namespace qs {
namespace {

void draw_box(const Viewer& viewer, const ControlsDrawer& controls) {
  controls.draw("Box");
  if (!viewer.crop.wish.boxed) return;
  for (const char* axis : {"x right", "y down", "z forward"})
    controls.draw_range(axis, 0.002 * viewer.scene->extent());
  controls.draw("Fit");
  ImGui::SameLine();
  controls.draw("Show all");
}

void draw_floaters(const ControlsDrawer& controls) {
  controls.draw("Floaters");
  ImGui::Indent();
  for (const char* name : {"faint", "opacity", "large", "of the core", "isolated", "neighbours"})
    controls.draw(name);
  ImGui::Unindent();
}

}  // namespace

void draw_crop(const Viewer& viewer, PanelState& state, Actions& actions) {
  const Crop& crop = viewer.crop;
  const ControlsDrawer controls(viewer, actions);
  ImGui::PushItemWidth(-7 * ImGui::GetFontSize());
  draw_box(viewer, controls);
  draw_floaters(controls);
  ImGui::PopItemWidth();
  ImGui::TextWrapped("%s", crop_text(viewer).c_str());
  controls.draw("Tint what goes");
  controls.draw("Apply");
  if (!crop.applied && !crop.done.empty()) ImGui::SameLine();
  controls.draw("Undo");
  if (!crop.applied) return;
  ImGui::SetNextItemWidth(-1);
  ImGui::InputTextWithHint("##file", "new file, e.g. cropped.ply; empty: a free name",
                           &state.crop_file);
  if (ImGui::Button("Save as"))
    actions.push_back(call(action::save_crop, std::filesystem::path(state.crop_file)));
  command_tooltip("Save the cropped scene");
}

}  // namespace qs
