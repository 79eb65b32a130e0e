// SPDX-License-Identifier: MIT
#include <algorithm>
#include <initializer_list>

#include <imgui.h>

#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

void row(const char* keys, const char* help) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(palette::kAccent, "%s", keys);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(help);
}

/// The widths of a column of keys and of their help, screen units: every text is whole.
struct HelpWidths {
  float keys = 0, help = 0;

  void hold(const char* key, const char* text) {
    keys = std::max(keys, ImGui::CalcTextSize(key).x);
    help = std::max(help, ImGui::CalcTextSize(text).x);
  }
  float both() const { return keys + help + 1.5f * ImGui::GetFontSize(); }
};

HelpWidths help_widths() {
  HelpWidths widths;
  for (const Gesture& gesture : gestures()) widths.hold(gesture.keys, gesture.help);
  for (const PadControl& control : pad_controls()) widths.hold(control.keys, control.help);
  for (const FlyKey& key : fly_keys()) widths.hold(key_name(key.key).c_str(), key.help);
  for (const KeyCommand& command : key_commands())
    widths.hold(key_name(command.key, command.mods).c_str(), command.help.c_str());
  return widths;
}

template <class Rows>
void section(const char* title, const HelpWidths& widths, const Rows& rows) {
  ImGui::TextColored(palette::kFaint, "%s", title);
  if (!ImGui::BeginTable(title, 2, ImGuiTableFlags_SizingFixedFit)) return;
  ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed, widths.keys);
  ImGui::TableSetupColumn("help", ImGuiTableColumnFlags_WidthFixed, widths.help);
  rows();
  ImGui::EndTable();
  ImGui::Spacing();
}

void menu_section(Menu menu, const HelpWidths& widths) {
  section(menu == Menu::none ? "Held" : kMenuNames[static_cast<int>(menu)], widths, [&] {
    for (const KeyCommand& command : key_commands()) {
      if (command.menu == menu)
        row(key_name(command.key, command.mods).c_str(), command.help.c_str());
    }
  });
}

void mouse_sections(const HelpWidths& widths) {
  section("Mouse", widths, [] {
    for (const Gesture& gesture : gestures()) row(gesture.keys, gesture.help);
  });
  section("Fly", widths, [] {
    for (const FlyKey& key : fly_keys()) row(key_name(key.key).c_str(), key.help);
  });
  menu_section(Menu::none, widths);
  section("Gamepad", widths, [] {
    for (const PadControl& control : pad_controls()) row(control.keys, control.help);
  });
}

void menu_sections(std::initializer_list<Menu> menus, const HelpWidths& widths) {
  for (const Menu menu : menus) menu_section(menu, widths);
}

// As many columns, up to three, as there is room for.
void draw_columns(const HelpWidths& widths, float room) {
  const int columns = std::clamp(static_cast<int>(room / widths.both()), 1, 3);
  if (!ImGui::BeginTable("columns", columns, ImGuiTableFlags_SizingFixedFit)) return;
  for (int i = 0; i < columns; ++i)
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, widths.both());
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  mouse_sections(widths);
  menu_sections({Menu::edit, Menu::train}, widths);
  if (columns < 3) menu_sections({Menu::camera, Menu::lens, Menu::mode}, widths);
  if (columns > 1) ImGui::TableNextColumn();
  menu_sections({Menu::file, Menu::view, Menu::measure, Menu::window, Menu::help}, widths);
  if (columns == 3) {
    ImGui::TableNextColumn();
    menu_sections({Menu::camera, Menu::lens, Menu::mode}, widths);
  }
  ImGui::EndTable();
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
  draw_columns(help_widths(), display.x - 4 * ImGui::GetFontSize());
  ImGui::End();
  if (!open) actions.push_back(call(action::toggle_panel, &Panels::help));
}

}  // namespace qs
