// SPDX-License-Identifier: MIT
//
// The dialog Train, which starts a training run in the window: Enter trains, Escape closes. And the
// photograph beside the model's picture of the same view, in the panel Training.
#include <algorithm>
#include <span>
#include <string>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/training_actions.h"
#include "learn/run/strategy.h"

namespace qs {
namespace {

constexpr const char* kTrainTitle = "Train from photographs";

// `right`: screen units that stay free at the end of the line.
void draw_field(const char* title, const char* hint, std::string& text, float right = 0) {
  ImGui::TextUnformatted(title);
  ImGui::SetNextItemWidth(right > 0 ? -right : -1);
  ImGui::PushID(title);
  ImGui::InputTextWithHint("##text", hint, &text, ImGuiInputTextFlags_AutoSelectAll);
  ImGui::PopID();
}

// The field of the photographs' folder. Returns true if its button was pressed.
bool draw_data_field(TrainForm& form) {
  constexpr const char* kChoose = "Choose ...";
  const ImGuiStyle& style = ImGui::GetStyle();
  const float button = ImGui::CalcTextSize(kChoose).x + 2 * style.FramePadding.x;
  draw_field("Photographs", "a COLMAP folder, or one with transforms.json or cameras.json",
             form.data, button + style.ItemSpacing.x);
  ImGui::SameLine();
  return ImGui::Button(kChoose);
}

// entry_of(row) is the text of a row in the list, name_of(row) of the chosen row.
template <class Row, class NameOf, class EntryOf>
void choose(const char* title, std::span<const Row> rows, std::size_t& chosen,
            const NameOf& name_of, const EntryOf& entry_of) {
  ImGui::SetNextItemWidth(19 * ImGui::GetFontSize());
  if (!ImGui::BeginCombo(title, name_of(rows[chosen]))) return;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (ImGui::Selectable(entry_of(rows[i]).c_str(), i == chosen)) chosen = i;
  ImGui::EndCombo();
}

void draw_choices(TrainForm& form) {
  ImGui::SetNextItemWidth(19 * ImGui::GetFontSize());
  ImGui::InputInt("iterations; 0: as the photographs need", &form.iterations, 1000, 10000);
  form.iterations = std::max(form.iterations, 0);
  choose(
      "size of the photographs", std::span<const TrainChoice>(kTrainSizes), form.size,
      [](const TrainChoice& row) { return row.words; },
      [](const TrainChoice& row) { return std::string(row.words); });
  choose(
      "how Gaussians are added", train::strategies(), form.strategy,
      [](const train::Strategy& row) { return row.name; },
      [](const train::Strategy& row) { return fmt::format("{}: {}", row.name, row.summary); });
}

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

void draw_train(const Viewer& viewer, PanelState& state, Actions& actions) {
  // The dialog Open takes its place while a folder is chosen.
  if (!viewer.panels.train || viewer.panels.open) return;
  TrainForm form = viewer.train_form;
  if (!ImGui::IsPopupOpen(kTrainTitle)) {
    ImGui::OpenPopup(kTrainTitle);
    state.focus_train = true;
  }
  bool open = true;
  if (!begin_dialog(kTrainTitle, 38, 0, open)) return;
  if (std::exchange(state.focus_train, false)) ImGui::SetKeyboardFocusHere();
  const bool chooses = draw_data_field(form);
  const std::string usual =
      form.data.empty() ? "folder of the trained model" : usual_model(form.data);
  draw_field("Model", usual.c_str(), form.model);
  draw_choices(form);
  draw_field("More options", "as of quadsplat train, e.g. --masks \"my masks\" --eval-every 5000",
             form.more);
  draw_wrapped(palette::kFaint,
               "The window shows the model while it is trained. The folder is new or empty: "
               "--resume continues a run in it, --overwrite replaces its files.");
  const bool entered = enter_pressed();
  const bool starts = (ImGui::Button("Train") || entered) && !form.data.empty();
  ImGui::SameLine();
  if (ImGui::Button("Cancel") || pressed(ImGuiKey_Escape)) open = false;
  if (form != viewer.train_form)
    actions.push_back([form](Viewer& v, Host&) { v.train_form = form; });
  if (starts) actions.push_back(call(action::start_training, request_of(form)));
  if (starts || !open) actions.push_back(call(action::toggle_panel, &Panels::train));
  if (chooses) actions.push_back(call(action::toggle_open_dialog, Choosing::photographs));
  if (starts || !open || chooses) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

void draw_test_view(const Viewer& viewer, const PanelState& state, Actions& actions) {
  const Training& training = *viewer.training;
  if (!training.views) return;
  draw_steps(training, actions);
  ImGui::SameLine();
  ImGui::TextWrapped("%s", test_view_title(training).c_str());
  const ImVec2 size = picture_size(training.views->cameras[training.test_view.view]);
  draw_test_picture("photograph", state.test_photograph, size);
  same_line_if_fits(std::max(size.x, ImGui::CalcTextSize("render").x));
  draw_test_picture("render", state.test_picture, size);
  ImGui::TextWrapped("%s", test_view_text(viewer).c_str());
  if (training.views->held_out) return;
  draw_wrapped(palette::kCaution, "No view is held out: the model is trained from this one.");
}

}  // namespace qs
