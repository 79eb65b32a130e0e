// SPDX-License-Identifier: MIT
//
// The dialog Train: starts a training run in the window. Enter trains, Escape closes.
#include <algorithm>
#include <sstream>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/training_actions.h"

namespace qs {
namespace {

constexpr const char* kTrainTitle = "Train from photographs";

// "garden/" -> "garden_model"
std::string usual_model(const std::string& data) {
  const std::filesystem::path path = std::filesystem::path(data).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).string() + "_model";
}

TrainingRequest request_of(const PanelState& state) {
  const auto& [data, model, options, focus] = state.train;
  TrainingRequest request{data, model.empty() ? usual_model(data) : model, {}};
  std::istringstream words(options);
  for (std::string word; words >> word;) request.options.push_back(word);
  return request;
}

void draw_field(const char* title, const char* hint, std::string& text) {
  ImGui::TextUnformatted(title);
  ImGui::SetNextItemWidth(-1);
  ImGui::PushID(title);
  ImGui::InputTextWithHint("##text", hint, &text, ImGuiInputTextFlags_AutoSelectAll);
  ImGui::PopID();
}

}  // namespace

void draw_train(const Viewer& viewer, PanelState& state, Actions& actions) {
  if (!viewer.panels.train) return;
  auto& [data, model, options, focus] = state.train;
  if (!ImGui::IsPopupOpen(kTrainTitle)) {
    ImGui::OpenPopup(kTrainTitle);
    focus = true;
  }
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float em = ImGui::GetFontSize();
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(38 * em, display.x - em), 0});
  bool open = true;
  if (!ImGui::BeginPopupModal(
          kTrainTitle, &open,
          ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize))
    return;
  if (std::exchange(focus, false)) ImGui::SetKeyboardFocusHere();
  draw_field("Photographs", "a COLMAP folder, or one with transforms.json or cameras.json", data);
  const std::string usual = data.empty() ? "folder of the trained model" : usual_model(data);
  draw_field("Model", usual.c_str(), model);
  draw_field("Options", "as of quadsplat train, e.g. --iterations 7000 --resolution-scale 2",
             options);
  ImGui::PushTextWrapPos(0);
  ImGui::TextColored(palette::kFaint,
                     "The window shows the model while it is trained. The folder is new or empty: "
                     "--resume continues a run in it, --overwrite replaces its files.");
  ImGui::PopTextWrapPos();
  const bool entered = enter_pressed();
  const bool starts = (ImGui::Button("Train") || entered) && !data.empty();
  ImGui::SameLine();
  if (ImGui::Button("Cancel") || pressed(ImGuiKey_Escape)) open = false;
  if (starts) actions.push_back(call(action::start_training, request_of(state)));
  if (starts || !open) {
    actions.push_back(call(action::toggle_panel, &Panels::train));
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

}  // namespace qs
