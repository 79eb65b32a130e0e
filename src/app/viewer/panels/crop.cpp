// SPDX-License-Identifier: MIT
//
// Crop and clean: the box and the criteria of floaters, the count of Gaussians to remove, Apply,
// Undo and Save as. The box's handles are in overlay.cpp.
#include <imgui.h>
#include <imgui_stdlib.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

void draw_box(const ViewedScene& scene, CropWish& wish, Actions& actions) {
  ImGui::Checkbox("Box", &wish.boxed);
  if (!wish.boxed) return;
  const auto speed = static_cast<float>(0.002 * scene.extent());
  constexpr const char* kAxes[] = {"x right", "y down", "z forward"};
  for (int axis = 0; axis < 3; ++axis)
    ImGui::DragFloatRange2(kAxes[axis], &wish.box.low[axis], &wish.box.high[axis], speed, 0, 0,
                           "%.3f", "%.3f");
  if (ImGui::Button("Fit")) actions.push_back(call(action::fit_crop_box));
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("The box around the scene's subject");
  ImGui::SameLine();
  if (ImGui::Button("Show all")) actions.push_back(call(action::show_crop_box));
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("Moves the camera until the whole box is visible");
}

void draw_floaters(CropWish& wish) {
  ImGui::Checkbox("Floaters", &wish.cleans);
  if (!wish.cleans) return;
  Floaters& floaters = wish.floaters;
  const auto row = [](const char* title, bool& on, const char* help, auto&& draw_limit) {
    ImGui::Checkbox(title, &on);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", help);
    if (!on) return;
    ImGui::PushID(title);
    draw_limit();
    ImGui::PopID();
  };
  ImGui::Indent();
  row("faint", floaters.faint, "less opaque than this", [&] {
    ImGui::SliderFloat("opacity", &floaters.least_opacity, 0.004f, 1, "%.3f",
                       ImGuiSliderFlags_Logarithmic);
  });
  row("large", floaters.large, "a standard deviation longer than this part of the scene's core",
      [&] {
        ImGui::SliderFloat("of the core", &floaters.largest_size, 0.005f, 2, "%.3f",
                           ImGuiSliderFlags_Logarithmic);
      });
  row("isolated", floaters.isolated, "fewer neighbours than this around it",
      [&] { ImGui::SliderInt("neighbours", &floaters.fewest_neighbours, 1, 200); });
  ImGui::Unindent();
}

}  // namespace

void draw_crop(const Viewer& viewer, PanelState& state, Actions& actions) {
  const Crop& crop = viewer.crop;
  CropWish wish = crop.wish;
  ImGui::PushItemWidth(-7 * ImGui::GetFontSize());
  draw_box(*viewer.scene, wish, actions);
  draw_floaters(wish);
  ImGui::PopItemWidth();
  if (wish != crop.wish) actions.push_back(call(action::change_crop, wish));
  ImGui::TextWrapped("%s", crop_text(viewer).c_str());
  bool marks = crop.marks;
  if (ImGui::Checkbox("Tint what goes", &marks))
    actions.push_back(call(action::mark_removed, marks));
  if (!crop.applied) {
    if (ImGui::Button("Apply")) actions.push_back(call(action::apply_crop));
    command_tooltip("Apply or undo the crop");
  }
  if (crop.applied || !crop.done.empty()) {
    if (!crop.applied) ImGui::SameLine();
    if (ImGui::Button("Undo")) actions.push_back(call(action::undo_crop));
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("The scene before the last crop");
  }
  if (!crop.applied) return;
  ImGui::SetNextItemWidth(-1);
  ImGui::InputTextWithHint("##file", "new file, e.g. cropped.ply; empty: a free name",
                           &state.crop_file);
  if (ImGui::Button("Save as"))
    actions.push_back(call(action::save_crop, std::filesystem::path(state.crop_file)));
  command_tooltip("Save the cropped scene");
}

}  // namespace qs
