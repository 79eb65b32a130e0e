// SPDX-License-Identifier: MIT
#include <imgui.h>

#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

constexpr float kKeys = 6, kColumn = 20;  // widths in letters' heights

void row(const char* keys, const char* help) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(palette::kAccent, "%s", keys);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(help);
}

template <class Rows>
void section(const char* title, const Rows& rows) {
  ImGui::TextColored(palette::kFaint, "%s", title);
  if (!ImGui::BeginTable(title, 2, ImGuiTableFlags_SizingFixedFit)) return;
  ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed, kKeys * ImGui::GetFontSize());
  ImGui::TableSetupColumn("help", ImGuiTableColumnFlags_WidthFixed,
                          (kColumn - kKeys - 1) * ImGui::GetFontSize());
  rows();
  ImGui::EndTable();
  ImGui::Spacing();
}

void menu_section(Menu menu) {
  section(menu == Menu::none ? "Held" : kMenuNames[static_cast<int>(menu)], [&] {
    for (const KeyCommand& command : key_commands()) {
      if (command.menu == menu)
        row(key_name(command.key, command.mods).c_str(), command.help.c_str());
    }
  });
}

}  // namespace

void draw_help(const Viewer&, Actions& actions) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  // Below the menu bar.
  const float menu = ImGui::GetFrameHeight();
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * (menu + display.y)}, ImGuiCond_Always,
                          {0.5f, 0.5f});
  ImGui::SetNextWindowSizeConstraints({0, 0}, {display.x, display.y - menu});
  ImGui::SetNextWindowFocus();
  bool open = true;
  ImGui::Begin("Help", &open,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove);
  if (ImGui::BeginTable("columns", 3, ImGuiTableFlags_SizingFixedFit)) {
    for (int i = 0; i < 3; ++i)
      ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, kColumn * ImGui::GetFontSize());
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    section("Mouse", [] {
      for (const Gesture& gesture : gestures()) row(gesture.keys, gesture.help);
    });
    section("Fly", [] {
      for (const FlyKey& key : fly_keys()) row(key_name(key.key).c_str(), key.help);
    });
    menu_section(Menu::none);
    ImGui::TableNextColumn();
    menu_section(Menu::file);
    menu_section(Menu::view);
    menu_section(Menu::measure);
    menu_section(Menu::help);
    ImGui::TableNextColumn();
    menu_section(Menu::camera);
    menu_section(Menu::mode);
    ImGui::EndTable();
  }
  ImGui::End();
  if (!open) actions.push_back(call(action::toggle_panel, &Panels::help));
}

}  // namespace qs
