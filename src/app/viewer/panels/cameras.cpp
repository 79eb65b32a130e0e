// SPDX-License-Identifier: MIT
//
// The cameras of the data set, and the camera path.
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

void draw_list(const Viewer& viewer, Actions& actions) {
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
        actions.push_back(call(action::go_to_camera, i));
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

void draw_path(const Viewer& viewer, Actions& actions) {
  ImGui::TextColored(palette::kFaint, "Path: %d keyframes",
                     static_cast<int>(viewer.keyframes.size()));
  for (std::size_t i = 0; i < viewer.keyframes.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::SmallButton("x")) actions.push_back(call(action::remove_keyframe, i));
    ImGui::SameLine();
    bool eases = viewer.keyframes[i].eases;
    if (ImGui::Checkbox("ease", &eases)) actions.push_back(call(action::ease_keyframe, i, eases));
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("the camera slows down to a stop here");
    ImGui::SameLine();
    if (i > 0) {
      const double before = viewer.keyframes[i - 1].time;
      auto seconds = static_cast<float>(viewer.keyframes[i].time - before);
      ImGui::SetNextItemWidth(5 * ImGui::GetFontSize());
      if (ImGui::DragFloat("##seconds", &seconds, 0.02f, 0.05f, 3600, "+%.2f s"))
        actions.push_back(call(action::delay_keyframe, i, static_cast<double>(seconds)));
      ImGui::SameLine();
    }
    if (ImGui::Selectable(keyframe_label(viewer, i).c_str()))
      actions.push_back(call(action::set_camera, viewer.keyframes[i].camera));
    ImGui::PopID();
  }
  if (ImGui::Button("Set here")) actions.push_back(call(action::add_keyframe));
  command_tooltip("Set a keyframe");
  ImGui::SameLine();
  if (ImGui::Button("Film")) actions.push_back(call(action::film));
  command_tooltip("Film of the path, or round the scene");
  if (viewer.keyframes.size() < 2) return;
  ImGui::SameLine();
  if (ImGui::Button(viewer.playback.running ? "Stop" : "Play"))
    actions.push_back(call(action::toggle_playback));
  command_tooltip("Play the path");
  ImGui::SameLine();
  if (ImGui::Button("Save")) actions.push_back(call(action::save_keyframes));
  ImGui::SameLine();
  bool loop = viewer.loops_path;
  if (ImGui::Checkbox("loop", &loop))
    actions.push_back(call(action::toggle_option, &Viewer::loops_path));
  auto time = static_cast<float>(viewer.playback.time);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##time", &time, static_cast<float>(viewer.keyframes.front().time),
                         static_cast<float>(viewer.path_end()), "%.2f s"))
    actions.push_back(call(action::seek, static_cast<double>(time)));
}

}  // namespace

void draw_cameras(const Viewer& viewer, PanelState&, Actions& actions) {
  draw_list(viewer, actions);
  ImGui::Separator();
  draw_path(viewer, actions);
}

}  // namespace qs
