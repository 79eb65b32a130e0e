// SPDX-License-Identifier: MIT
//
// The dialog Open. It takes the keyboard: typing changes the path, the arrow keys select a row,
// Enter opens, Escape closes.
#include <algorithm>
#include <system_error>
#include <utility>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

// Index = Choosing.
constexpr const char* kTitles[] = {"Open", "Open beside", "Folder of the photographs",
                                   "Folder of the results"};

bool chooses_folder(const Viewer& viewer) { return chooses_folder(viewer.choosing); }

fs::path start_folder(const Viewer& viewer) {
  std::error_code error;
  const fs::path typed = viewer.train_form.data;
  if (viewer.choosing == Choosing::photographs && fs::is_directory(typed, error)) return typed;
  return viewer.scene ? viewer.scene->path.parent_path() : fs::current_path(error);
}

// Inserts into the field the text that was typed before the field had the keyboard.
int insert_early(ImGuiInputTextCallbackData* data) {
  auto& early = *static_cast<std::string*>(data->UserData);
  if (early.empty()) return 0;
  data->InsertChars(0, early.c_str());
  data->CursorPos = data->BufTextLen;
  data->ClearSelection();
  early.clear();
  return 0;
}

void draw_path_field(const Viewer& viewer, PanelState& state) {
  FileChooser& chooser = state.chooser;
  std::string typed = chooser.typed();
  if (draw_first_field(state, chooser.moves(),
                       chooses_folder(viewer) ? "path of the folder"
                                              : "path of a scene, a model folder or cameras",
                       typed))
    chooser.type(typed);
}

std::optional<fs::path> draw_rows(PanelState& state) {
  FileChooser& chooser = state.chooser;
  constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_BordersOuter;
  // A line of text and the buttons.
  const float below = ImGui::GetTextLineHeightWithSpacing() + ImGui::GetFrameHeightWithSpacing();
  if (!ImGui::BeginTable("files", 3, kFlags, {0, -below})) return std::nullopt;
  const float em = ImGui::GetFontSize();
  ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn("size", ImGuiTableColumnFlags_WidthFixed, 6 * em);
  ImGui::TableSetupColumn("date", ImGuiTableColumnFlags_WidthFixed, 6 * em);
  std::optional<FileEntry> clicked;
  for (std::size_t i = 0; i < chooser.rows().size(); ++i) {
    const FileEntry& entry = chooser.rows()[i];
    const bool selected = static_cast<int>(i) == chooser.selected();
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    const std::string name = fitted(entry.name, ImGui::GetContentRegionAvail().x);
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::Selectable(name.c_str(), selected, ImGuiSelectableFlags_SpanAllColumns))
      clicked = entry;
    ImGui::PopID();
    if (name != entry.name && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", entry.name.c_str());
    if (selected && state.scroll_files) ImGui::SetScrollHereY();
    for (const std::string& text : {entry.size, entry.date}) {
      ImGui::TableNextColumn();
      ImGui::PushStyleColor(ImGuiCol_Text, palette::kFaint);
      right_aligned(text);
      ImGui::PopStyleColor();
    }
  }
  state.scroll_files = false;
  ImGui::EndTable();
  return clicked ? chooser.choose(*clicked) : std::nullopt;
}

// Returns the path to open.
std::optional<fs::path> use_keys(PanelState& state) {
  FileChooser& chooser = state.chooser;
  const int by = (pressed(ImGuiKey_DownArrow) ? 1 : 0) - (pressed(ImGuiKey_UpArrow) ? 1 : 0);
  if (by != 0) chooser.select(by);
  state.scroll_files |= by != 0;
  if (!enter_pressed()) return std::nullopt;
  if (!state.typed_early.empty())
    chooser.type(std::exchange(state.typed_early, "") + chooser.typed());
  state.focus_path = true;
  return chooser.enter();
}

// Lines below the rows: help or a problem, and the buttons. Returns the path to open.
std::optional<fs::path> draw_end(const Viewer& viewer, const FileChooser& chooser, bool& open) {
  std::optional<fs::path> chosen;
  const bool folder = chooses_folder(viewer);
  if (chooser.problem().empty()) {
    ImGui::TextColored(palette::kFaint, "%s",
                       folder ? "Enter takes this folder, arrow keys select, Escape closes"
                              : "Enter opens, arrow keys select, Escape closes");
  } else {
    ImGui::TextColored(palette::kCaution, "%s", chooser.problem().c_str());
  }
  if (ImGui::Button(folder ? "Take this folder" : "Open this folder as a model"))
    chosen = chooser.folder();
  ImGui::SameLine();
  if (ImGui::Button("Cancel") || pressed(ImGuiKey_Escape)) open = false;
  return chosen;
}

}  // namespace

bool draw_first_field(PanelState& state, int identity, const char* hint, std::string& text) {
  ImGui::PushID(identity);
  if (state.focus_path) {
    ImGui::SetKeyboardFocusHere();
    // The field drops input until the frame after it has become active.
    for (const ImWchar c : ImGui::GetIO().InputQueueCharacters)
      if (c >= ' ' && c < 127) state.typed_early += static_cast<char>(c);
    ImGui::GetIO().ClearInputCharacters();
  }
  ImGui::SetNextItemWidth(-1);
  const bool changed = ImGui::InputTextWithHint(
      "##first", hint, &text, ImGuiInputTextFlags_CallbackAlways, insert_early, &state.typed_early);
  if (ImGui::IsItemActive()) state.focus_path = false;
  ImGui::PopID();
  return changed;
}

void draw_open(const Viewer& viewer, PanelState& state, Actions& actions) {
  if (!viewer.panels.open) return;
  FileChooser& chooser = state.chooser;
  const char* const title = kTitles[static_cast<int>(viewer.choosing)];
  if (!ImGui::IsPopupOpen(title)) {
    ImGui::OpenPopup(title);
    chooser.start(start_folder(viewer), chooses_folder(viewer));
    state.typed_early.clear();
    state.focus_path = true;
  }
  bool open = true;
  if (!begin_dialog(title, 44, 30, open)) return;
  draw_path_field(viewer, state);
  ImGui::TextColored(palette::kFaint, "%s", chooser.folder().c_str());
  std::optional<fs::path> chosen = draw_rows(state);
  if (const auto path = use_keys(state)) chosen = path;
  if (const auto path = draw_end(viewer, chooser, open)) chosen = path;
  if (chosen) actions.push_back(call(action::path_chosen, *chosen, viewer.choosing));
  if (chosen || !open) {
    actions.push_back(call(action::toggle_panel, &Panels::open));
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

}  // namespace qs
