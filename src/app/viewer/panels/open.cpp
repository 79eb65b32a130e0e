// SPDX-License-Identifier: MIT
//
// Chooses a file to open: a list of folders and of readable files, and a line for a path.
#include <algorithm>
#include <sstream>
#include <system_error>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "io/scene/reader.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

bool readable(const fs::path& path) {
  const std::string ending = path.extension().string();
  if (ending == ".json") return true;
  const auto rows = readers();
  return std::any_of(rows.begin(), rows.end(), [&](const ReaderRow& row) {
    std::istringstream words(row.extensions);
    for (std::string word; words >> word;) {
      if (word == ending) return true;
    }
    return false;
  });
}

void list(PanelState& state, const fs::path& folder) {
  state.folder = folder;
  state.entries.clear();
  std::error_code error;
  for (const auto& entry :
       fs::directory_iterator(folder, fs::directory_options::skip_permission_denied, error)) {
    if (entry.path().filename().string().starts_with('.')) continue;
    std::error_code unreachable;
    if (entry.is_directory(unreachable) || readable(entry.path()))
      state.entries.push_back(entry.path());
  }
  std::sort(state.entries.begin(), state.entries.end(), [](const fs::path& a, const fs::path& b) {
    std::error_code unreachable;
    const bool a_file = !fs::is_directory(a, unreachable),
               b_file = !fs::is_directory(b, unreachable);
    return a_file != b_file ? b_file : a < b;
  });
}

fs::path start_folder(const Viewer& viewer) {
  std::error_code error;
  return viewer.scene ? viewer.scene->path.parent_path() : fs::current_path(error);
}

}  // namespace

void draw_open(const Viewer& viewer, PanelState& state, Actions& actions) {
  if (state.folder.empty()) list(state, fs::absolute(start_folder(viewer)));
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Appearing, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({38 * ImGui::GetFontSize(), 26 * ImGui::GetFontSize()},
                           ImGuiCond_Appearing);
  bool open = true;
  std::optional<fs::path> chosen, next;
  ImGui::Begin("Open", &open, ImGuiWindowFlags_NoCollapse);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::InputTextWithHint("##path", "path of a scene, a model folder or cameras", &state.typed,
                               ImGuiInputTextFlags_EnterReturnsTrue))
    chosen = state.typed;
  ImGui::TextColored(palette::kFaint, "%s", state.folder.c_str());
  ImGui::BeginChild("files", {0, -2 * ImGui::GetFrameHeightWithSpacing()}, true);
  if (ImGui::Selectable("..")) next = state.folder.parent_path();
  for (const fs::path& entry : state.entries) {
    std::error_code error;
    const bool folder = fs::is_directory(entry, error);
    const std::string label = fmt::format("{}{}", entry.filename().string(), folder ? "/" : "");
    if (ImGui::Selectable(label.c_str())) (folder ? next : chosen) = entry;
  }
  ImGui::EndChild();
  if (ImGui::Button("Open this folder as a model")) chosen = state.folder;
  ImGui::SameLine();
  if (ImGui::Button("Cancel")) open = false;
  ImGui::End();
  if (next) list(state, *next);
  if (chosen) {
    actions.push_back(call(action::open, *chosen));
    open = false;
  }
  if (!open) {
    actions.push_back(call(action::toggle_panel, &Panels::open));
    state.folder.clear();
  }
}

}  // namespace qs
