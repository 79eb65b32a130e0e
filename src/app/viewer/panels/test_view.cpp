// SPDX-License-Identifier: MIT
//
// A photograph beside the model's picture of the same view, in the panel Training.
#include <algorithm>

#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/training_actions.h"

namespace qs {
namespace {

// Both pictures have this size: half of the panel's width, and at most a part of the window's
// height, so that portraits stay in view.
ImVec2 picture_size(const Camera& camera) {
  constexpr float kMostHeight = 0.44f;  // of the window's
  const float gap = ImGui::GetStyle().ItemSpacing.x;
  const float width = std::max(1.0f, 0.5f * (ImGui::GetContentRegionAvail().x - gap));
  const float aspect = static_cast<float>(camera.width) / static_cast<float>(camera.height);
  const float height =
      std::max(1.0f, std::min(width / aspect, kMostHeight * ImGui::GetIO().DisplaySize.y));
  return {std::min(width, height * aspect), height};
}

// A dark area stands for a picture that is still missing.
void draw_test_picture(const char* title, unsigned texture, ImVec2 size) {
  ImGui::BeginGroup();
  ImGui::TextColored(palette::kFaint, "%s", title);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImVec2 end{at.x + size.x, at.y + size.y};
  if (texture == 0) {
    draw.AddRectFilled(at, end, IM_COL32(0, 0, 0, 110));
  } else {
    draw.AddImage(texture_id(texture), at, end);
  }
  ImGui::Dummy(size);
  ImGui::EndGroup();
}

void draw_steps(const Training& training, Actions& actions) {
  ImGui::BeginDisabled(training.views->cameras.size() < 2);
  if (ImGui::ArrowButton("previous view", ImGuiDir_Left))
    actions.push_back(call(action::step_test_view, -1));
  ImGui::SameLine();
  if (ImGui::ArrowButton("next view", ImGuiDir_Right))
    actions.push_back(call(action::step_test_view, 1));
  ImGui::EndDisabled();
}

}  // namespace

void draw_test_view(const Viewer& viewer, const PanelState& state, Actions& actions) {
  const Training& training = *viewer.training;
  if (!training.views) return;
  draw_steps(training, actions);
  ImGui::SameLine();
  ImGui::TextWrapped("%s", test_view_title(training).c_str());
  const ImVec2 size = picture_size(training.views->cameras[training.test_view.view]);
  draw_test_picture("photograph", state.test_photograph, size);
  ImGui::SameLine();
  draw_test_picture("render", state.test_picture, size);
  ImGui::TextWrapped("%s", test_view_text(viewer).c_str());
  if (training.views->held_out) return;
  draw_wrapped(palette::kCaution, "No view is held out: the model is trained from this one.");
}

}  // namespace qs
