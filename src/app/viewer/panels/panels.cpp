// SPDX-License-Identifier: MIT
#include "app/viewer/panels/panels.h"

#include <algorithm>

#include <glm/common.hpp>
#include <imgui.h>

#include "app/viewer/commands/commands.h"

namespace qs {

std::optional<std::size_t> cell_under_mouse(const Viewer& viewer, int cell_px, int columns,
                                            int rows) {
  const glm::dvec2 cursor = viewer.cursor;
  const glm::ivec2 at = glm::ivec2(glm::floor(cursor)) / std::max(cell_px, 1);
  const bool inside = cursor.x >= 0 && cursor.y >= 0 && at.x < columns && at.y < rows;
  if (!inside || ImGui::GetIO().WantCaptureMouse) return std::nullopt;
  return static_cast<std::size_t>(at.y * columns + at.x);
}

void right_aligned(const std::string& text) {
  const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(text.c_str()).x;
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(0.0f, room));
  ImGui::TextUnformatted(text.c_str());
}

void command_tooltip(const char* help) {
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", command_hint(help).c_str());
}

void draw_panels(const Viewer& viewer, PanelState& state, Actions& actions) {
  draw_overlay(viewer, state);
  draw_heat_legend(viewer);
  const float top = viewer.panels.all ? draw_menu_bar(viewer, actions) : 0;
  draw_divider(viewer, actions, top);
  if (viewer.panels.all) {
    if (viewer.panels.hud && viewer.scene) draw_hud(viewer, actions, top);
    if (viewer.panels.info && viewer.scene) draw_info(viewer, actions, top);
    if (viewer.panels.cameras && viewer.scene) draw_cameras(viewer, actions, top);
    if (viewer.panels.recorder) draw_recorder(viewer, actions, top);
    if (viewer.panels.inspector && viewer.scene) draw_inspector(viewer, state, actions, top);
    if (viewer.panels.split && viewer.scene) draw_split(viewer, actions, top);
    draw_verdict(viewer, actions);
    // It asks for the focus at every frame, which would close the dialog.
    if (viewer.panels.help && !viewer.panels.open) draw_help(viewer, actions);
    if (!viewer.scene && !viewer.loading) draw_welcome(viewer, actions);
  }
  draw_messages(viewer, actions);
  draw_open(viewer, state, actions);
}

}  // namespace qs
