// SPDX-License-Identifier: MIT
//
// The dialog Train: starts a training run in the window. Enter trains, Escape closes.
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
  ImGui::InputInt("iterations", &form.iterations, 1000, 10000);
  form.iterations = std::max(form.iterations, 1);
  choose(
      "size of the photographs", std::span<const TrainChoice>(kTrainSizes), form.size,
      [](const TrainChoice& row) { return row.words; },
      [](const TrainChoice& row) { return std::string(row.words); });
  choose(
      "how Gaussians are added", train::strategies(), form.strategy,
      [](const train::Strategy& row) { return row.name; },
      [](const train::Strategy& row) { return fmt::format("{}: {}", row.name, row.summary); });
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

}  // namespace qs
