// SPDX-License-Identifier: MIT
//
// Two dialogs: the palette, which finds commands and controls of panels by words, and the question
// what to do with work that is not saved.
#include <algorithm>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/controls.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/kept_work.h"

namespace qs {

void draw_palette(const Viewer& viewer, PanelState& state, Actions& actions) {
  constexpr const char* kTitle = "Find a command";
  if (!viewer.panels.palette) return;
  if (!ImGui::IsPopupOpen(kTitle)) {
    ImGui::OpenPopup(kTitle);
    state.words.clear();
    state.typed_early.clear();
    state.chosen_command = 0;
    state.focus_path = true;
  }
  bool open = true;
  if (!begin_dialog(kTitle, 36, 24, open)) return;
  if (draw_first_field(state, 0, "words, arrow keys select, Enter runs", state.words))
    state.chosen_command = 0;
  struct Found {
    std::string label, key;
    Action action;
  };
  std::vector<Found> found;
  for (const KeyCommand* row : find_commands(state.words, viewer))
    found.push_back({std::string(kMenuNames[static_cast<int>(row->menu)]) + ": " + menu_label(*row),
                     key_name(row->key, row->mods),
                     row->panel == &Panels::palette ? call([](Viewer&) {}) : row->action});
  for (const NamedUse& use : find_uses(state.words, viewer))
    found.push_back({use.label, "", use.action});
  const int last = static_cast<int>(found.size()) - 1;
  const int by = (pressed(ImGuiKey_DownArrow) ? 1 : 0) - (pressed(ImGuiKey_UpArrow) ? 1 : 0);
  state.chosen_command = std::clamp(state.chosen_command + by, 0, std::max(last, 0));
  const Found* run = nullptr;
  ImGui::BeginChild("commands");
  for (int i = 0; i <= last; ++i) {
    const Found& row = found[static_cast<std::size_t>(i)];
    const bool chosen = i == state.chosen_command;
    if (ImGui::Selectable(row.label.c_str(), chosen) || (chosen && enter_pressed())) run = &row;
    if (chosen && by != 0) ImGui::SetScrollHereY();
    ImGui::SameLine();
    right_aligned(row.key);
  }
  ImGui::EndChild();
  if (run != nullptr || !open || pressed(ImGuiKey_Escape)) {
    actions.push_back(call(action::toggle_panel, &Panels::palette));
    if (run != nullptr) actions.push_back(run->action);
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

void draw_leaving(const Viewer& viewer, Actions& actions) {
  constexpr const char* kTitle = "Not saved";
  if (!viewer.leaving) return;
  if (!ImGui::IsPopupOpen(kTitle)) ImGui::OpenPopup(kTitle);
  bool open = true;
  if (!begin_dialog(kTitle, 30, 0, open)) return;
  ImGui::TextWrapped("Not saved: %s.", unsaved_text(viewer, *viewer.leaving).c_str());
  const std::size_t before = actions.size();
  if (ImGui::Button("Save") || enter_pressed())
    actions.push_back(call(action::save_and_leave, *viewer.leaving));
  ImGui::SameLine();
  if (ImGui::Button("Discard")) actions.push_back(call(action::leave_now, *viewer.leaving, false));
  ImGui::SameLine();
  if (ImGui::Button("Back") || !open || pressed(ImGuiKey_Escape))
    actions.push_back([](Viewer& v, Host&) { v.leaving.reset(); });
  if (actions.size() > before) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

}  // namespace qs
