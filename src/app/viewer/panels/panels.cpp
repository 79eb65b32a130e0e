// SPDX-License-Identifier: MIT
#include "app/viewer/panels/panels.h"

#include <imgui.h>

namespace qs {

bool mouse_is_free() { return !ImGui::GetIO().WantCaptureMouse; }

void draw_panels(const Viewer& viewer, PanelMemory& memory, Actions& actions) {
  draw_overlay(viewer, memory);
  draw_heat_legend(viewer, memory);
  const float top = viewer.panels.all ? draw_menu_bar(viewer, actions) : 0;
  draw_divider(viewer, actions, top);
  if (viewer.panels.all) {
    if (viewer.panels.hud && viewer.scene) draw_hud(viewer, actions, top);
    if (viewer.panels.info && viewer.scene) draw_info(viewer, actions, top);
    if (viewer.panels.cameras && viewer.scene) draw_cameras(viewer, actions, top);
    if (viewer.panels.recorder) draw_recorder(viewer, actions, top);
    if (viewer.panels.inspector && viewer.scene) draw_inspector(viewer, memory, actions, top);
    if (viewer.panels.split && viewer.scene) draw_split(viewer, memory, actions, top);
    if (viewer.panels.help) draw_help(viewer, actions);
    if (viewer.panels.open) draw_open(viewer, memory, actions);
    if (!viewer.scene && !viewer.loading) draw_welcome(viewer, actions);
  }
  draw_messages(viewer, actions);
}

}  // namespace qs
