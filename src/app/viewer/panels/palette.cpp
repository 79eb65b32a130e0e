// SPDX-License-Identifier: MIT
//
// Two dialogs: the palette, which finds commands by words, and the question what to do with work
// that is not saved.
#include <algorithm>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "app/viewer/commands/commands.h"
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
  const std::vector<const KeyCommand*> found = find_commands(state.words, viewer);
  const int last = static_cast<int>(found.size()) - 1;
  const int by = (pressed(ImGuiKey_DownArrow) ? 1 : 0) - (pressed(ImGuiKey_UpArrow) ? 1 : 0);
  state.chosen_command = std::clamp(state.chosen_command + by, 0, std::max(last, 0));
  const KeyCommand* run = nullptr;
  ImGui::BeginChild("commands");
  for (int i = 0; i <= last; ++i) {
    const KeyCommand& row = *found[static_cast<std::size_t>(i)];
    const bool chosen = i == state.chosen_command;
    const std::string label = std::string(kMenuNames[static_cast<int>(row.menu)]) + ": ";
    if (ImGui::Selectable((label + menu_label(row)).c_str(), chosen) || (chosen && enter_pressed()))
      run = &row;
    if (chosen && by != 0) ImGui::SetScrollHereY();
    ImGui::SameLine();
    right_aligned(key_name(row.key, row.mods));
  }
  ImGui::EndChild();
  if (run != nullptr || !open || pressed(ImGuiKey_Escape)) {
    actions.push_back(call(action::toggle_panel, &Panels::palette));
    if (run != nullptr && run->panel != &Panels::palette) actions.push_back(run->action);
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
