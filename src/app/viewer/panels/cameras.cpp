// SPDX-License-Identifier: MIT
//
// The cameras of the data set, and the camera path.
#include <imgui.h>

#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

void draw_list(const Viewer& viewer, const ControlsDrawer& controls, Actions& actions) {
  const ViewedScene& scene = *viewer.scene;
  if (scene.cameras.empty()) {
    ImGui::TextWrapped(
        "This scene came without cameras. Drop its cameras.json, transforms.json or "
        "COLMAP folder on the window.");
    return;
  }
  ImGui::BeginChild("list", {0, 10 * ImGui::GetTextLineHeightWithSpacing()});
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(scene.cameras.size()));
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const std::string label = camera_label(scene, static_cast<std::size_t>(i));
      if (ImGui::Selectable(label.c_str(), i == viewer.dataset_camera))
        controls.set("camera", 0, static_cast<std::size_t>(i));
    }
  }
  ImGui::EndChild();
  bool frusta = viewer.panels.frusta, photograph = viewer.panels.photograph;
  if (ImGui::Checkbox("in the scene", &frusta))
    actions.push_back(call(action::toggle_panel, &Panels::frusta));
  command_tooltip("Cameras in the scene");
  ImGui::SameLine();
  if (ImGui::Checkbox("photograph", &photograph))
    actions.push_back(call(action::toggle_photograph));
  command_tooltip("Photograph of this camera");
  if (viewer.panels.photograph) {
    float opacity = viewer.photograph_opacity;
    ImGui::SetNextItemWidth(10 * ImGui::GetFontSize());
    if (ImGui::SliderFloat("opacity", &opacity, 0, 1, "%.2f"))
      actions.push_back(call(action::set_photograph_opacity, opacity));
  }
}

void draw_keyframe(const Viewer& viewer, std::size_t i, const ControlsDrawer& controls) {
  if (ImGui::SmallButton("x")) controls.set("remove keyframe", 0, i);
  ImGui::SameLine();
  bool eases = viewer.keyframes[i].eases;
  if (ImGui::Checkbox("ease", &eases)) controls.set("ease", eases ? 1 : 0, i);
  controls.show_tooltip("ease");
  ImGui::SameLine();
  if (i > 0) {
    const double before = viewer.keyframes[i - 1].time;
    auto seconds = static_cast<float>(viewer.keyframes[i].time - before);
    ImGui::SetNextItemWidth(5 * ImGui::GetFontSize());
    if (ImGui::DragFloat("##seconds", &seconds, 0.02f, 0.05f, 3600, "+%.2f s"))
      controls.set("seconds", static_cast<double>(seconds), i);
    ImGui::SameLine();
  }
  if (ImGui::Selectable(keyframe_label(viewer, i).c_str())) controls.set("keyframe", 0, i);
}

void draw_path(const Viewer& viewer, const ControlsDrawer& controls) {
  ImGui::TextColored(palette::kFaint, "Path: %d keyframes",
                     static_cast<int>(viewer.keyframes.size()));
  for (std::size_t i = 0; i < viewer.keyframes.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    draw_keyframe(viewer, i, controls);
    ImGui::PopID();
  }
  controls.draw("Set here");
  ImGui::SameLine();
  controls.draw("Film");
  if (viewer.keyframes.size() < 2) return;
  for (const char* name : {"Play", "Save", "loop"}) {
    ImGui::SameLine();
    controls.draw(name);
  }
  ImGui::SetNextItemWidth(-1);
  controls.draw("time", "");
}

}  // namespace

void draw_cameras(const Viewer& viewer, PanelState&, Actions& actions) {
  const ControlsDrawer controls(viewer, actions);
  draw_list(viewer, controls, actions);
  ImGui::Separator();
  draw_path(viewer, controls);
}

}  // namespace qs
