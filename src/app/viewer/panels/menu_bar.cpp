// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <imgui.h>

#include "app/session/text.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/bindings.h"

namespace qs {
namespace {

void draw_recent(const Viewer& viewer, Actions& actions) {
  if (!ImGui::BeginMenu("Recent files", !viewer.recent.empty())) return;
  for (const std::filesystem::path& path : viewer.recent) {
    if (ImGui::MenuItem(path.c_str())) actions.push_back(action::Open{path});
  }
  ImGui::EndMenu();
}

void draw_menu(Menu menu, const Viewer& viewer, Actions& actions) {
  if (!ImGui::BeginMenu(kMenuNames[static_cast<int>(menu)])) return;
  for (const Binding& row : bindings()) {
    if (row.menu != menu) continue;
    const auto* mode = std::get_if<action::SetMode>(&row.action);
    const bool checked = (row.checked != nullptr && viewer.panels.*row.checked) ||
                         (mode != nullptr && mode->mode == viewer.settings.mode);
    if (ImGui::MenuItem(row.help.c_str(), key_name(row.key, row.mods).c_str(), checked))
      actions.push_back(row.action);
    if (mode != nullptr && ImGui::IsItemHovered())
      ImGui::SetTooltip("%s", row_of(mode->mode).summary);
  }
  if (menu == Menu::file) draw_recent(viewer, actions);
  if (menu == Menu::view) {
    ImGui::Separator();
    const auto option = [&](const char* name, bool Viewer::*which) {
      if (ImGui::MenuItem(name, nullptr, viewer.*which))
        actions.push_back(action::ToggleOption{which});
    };
    option("Draw on demand only", &Viewer::on_demand);
    option("Wait for the display (vsync)", &Viewer::vsync);
    option("Draw smaller while moving (CPU)", &Viewer::reduce_when_moving);
  }
  ImGui::EndMenu();
}

}  // namespace

float draw_menu_bar(const Viewer& viewer, Actions& actions) {
  if (!ImGui::BeginMainMenuBar()) return 0;
  for (const Menu menu : {Menu::file, Menu::view, Menu::camera, Menu::mode, Menu::measure})
    draw_menu(menu, viewer, actions);
  if (viewer.scene) {
    const std::string text = fmt::format(
        "{}   {} Gaussians   {}   {} x {}", viewer.scene->name, grouped(viewer.scene->gaussians),
        kBackendNames[static_cast<int>(viewer.backend)], viewer.camera.width, viewer.camera.height);
    const float width = ImGui::CalcTextSize(text.c_str()).x;
    ImGui::SameLine(ImGui::GetWindowWidth() - width - 2 * ImGui::GetStyle().WindowPadding.x);
    ImGui::TextColored(palette::kFaint, "%s", text.c_str());
  }
  const float height = ImGui::GetWindowSize().y;
  ImGui::EndMainMenuBar();
  return height;
}

}  // namespace qs
