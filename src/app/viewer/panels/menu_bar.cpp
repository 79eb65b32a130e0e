// SPDX-License-Identifier: MIT
//
// The lines above and below the picture.
#include <string>
#include <utility>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/panel_text.h"
#include "base/assets.h"
#include "version.h"

namespace qs {
namespace {

void draw_recent(const Viewer& viewer, Actions& actions) {
  if (!ImGui::BeginMenu("Recent files", !viewer.recent.empty())) return;
  for (const std::filesystem::path& path : viewer.recent) {
    ImGui::PushID(path.c_str());
    const float most = 20 * ImGui::GetFontSize();
    const std::string name = fitted(path.filename().string(), most);
    if (ImGui::MenuItem(name.c_str(), fitted(path.parent_path().string(), most).c_str()))
      actions.push_back(call(action::open, path));
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", path.c_str());
    ImGui::PopID();
  }
  ImGui::EndMenu();
}

// The version, the licence, the manual, and a report of a problem.
void draw_about(const Viewer& viewer, Actions& actions) {
  const std::string version = fmt::format("quadsplat {} (commit {})", kVersion, kCommit);
  ImGui::Separator();
  const auto page = [&](const char* label, const char* file) {
    const auto path = find_asset(file);
    if (ImGui::MenuItem(label, nullptr, false, path.has_value()))
      actions.push_back(call(&Host::open_with_desktop, *path));
  };
  page("Manual", "docs/viewer.md");
  page("Licence: MIT", "LICENSE");
  if (ImGui::MenuItem("Copy a report of a problem"))
    actions.push_back(call(action::copy_text, version + "\n" + state_json(viewer)));
  if (ImGui::MenuItem(version.c_str())) actions.push_back(call(action::copy_text, version));
}

void draw_menu(Menu menu, const Viewer& viewer, Actions& actions) {
  if (!ImGui::BeginMenu(kMenuNames[static_cast<int>(menu)])) return;
  if (pressed(ImGuiKey_Escape)) ImGui::CloseCurrentPopup();
  bool first = true;
  for (const KeyCommand& row : key_commands()) {
    if (row.menu != menu) continue;
    const bool checked = row.is_checked && row.is_checked(viewer);
    const bool enabled = row.without_scene || viewer.scene;
    if (row.line_above) ImGui::Separator();
    if (ImGui::MenuItem(menu_label(row).c_str(), key_name(row.key, row.mods).c_str(), checked,
                        enabled))
      actions.push_back(row.action);
    if (row.tooltip != nullptr && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", row.tooltip);
    if (menu == Menu::file && std::exchange(first, false)) draw_recent(viewer, actions);
  }
  if (menu == Menu::measure) {
    ImGui::Separator();
    draw_heat_scale_menu(viewer, actions);
  }
  if (menu == Menu::help) draw_about(viewer, actions);
  if (menu == Menu::view) {
    ImGui::Separator();
    const auto option = [&](const char* name, bool Viewer::*which) {
      if (ImGui::MenuItem(name, nullptr, viewer.*which))
        actions.push_back(call(action::toggle_option, which));
    };
    option("Draw on demand only", &Viewer::on_demand);
    option("Wait for the display (vsync)", &Viewer::vsync);
    ControlsDrawer drawer(viewer, actions);
    drawer.draw_menu_item("Draw smaller while moving (CPU)");
    drawer.draw_menu_item("Leave out hidden Gaussians (GPU)");
  }
  ImGui::EndMenu();
}

// At the right end of the menu bar; a text that would reach the menus is shortened.
void draw_summary(std::string text) {
  const float right = ImGui::GetWindowWidth() - 2 * ImGui::GetStyle().WindowPadding.x;
  const float room = right - ImGui::GetCursorPosX();
  text = fitted(text, room);
  const float width = ImGui::CalcTextSize(text.c_str()).x;
  if (width > room) return;
  ImGui::SameLine(right - width);
  ImGui::TextColored(palette::kFaint, "%s", text.c_str());
}

}  // namespace

void draw_menu_bar(const Viewer& viewer, Actions& actions) {
  if (!ImGui::BeginMainMenuBar()) return;
  for (int menu = 0; menu < static_cast<int>(Menu::none); ++menu)
    draw_menu(static_cast<Menu>(menu), viewer, actions);
  if (viewer.scene) draw_summary(scene_summary(viewer));
  ImGui::EndMainMenuBar();
}

void draw_status_line(const Viewer& viewer, const Rect& area) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  draw.AddRectFilled({area.low.x, area.low.y}, {area.high.x, area.high.y},
                     ImGui::GetColorU32(ImGuiCol_MenuBarBg));
  if (!viewer.scene && !viewer.loading) return;
  const float letter = ImGui::GetFontSize();
  const float y = area.center().y - 0.5f * letter;
  const StatusLine line = status_line(viewer);
  const auto width = [](const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x; };
  // Whole words are left out: of the note beyond most of the line, then numbers that do not fit.
  const float most = 0.7f * area.size().x;
  std::string note =
      fitting_parts(line.note, " ", [&](const std::string& text) { return width(text) <= most; });
  if (note.size() < line.note.size()) note += " ...";
  const float left = area.low.x + 0.8f * letter, right = area.high.x - width(note) - 0.8f * letter;
  const std::string numbers =
      fitting_parts(line.numbers, "  \u00b7  ",
                    [&](const std::string& text) { return left + width(text) + letter <= right; });
  draw.AddText({left, y}, ImGui::GetColorU32(line.faint ? palette::kFaint : palette::kText),
               numbers.c_str());
  draw.AddText({right, y}, ImGui::GetColorU32(line.caution ? palette::kCaution : palette::kFaint),
               note.c_str());
}

}  // namespace qs
