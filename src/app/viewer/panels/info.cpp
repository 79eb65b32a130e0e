// SPDX-License-Identifier: MIT
//
// The scene's facts and the render settings.
#include <imgui.h>

#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"

namespace qs {
void draw_info(const Viewer& viewer, PanelState&, Actions& actions) {
  for (const Fact& fact : scene_facts_of(viewer)) draw_fact(fact);
  ImGui::Separator();
  const ControlsDrawer controls(viewer, actions);
  ImGui::PushItemWidth(9 * ImGui::GetFontSize());
  for (const char* name : {"SH degree", "splat scale", "background", "antialias", "backend",
                           "pipeline", "leave out what is larger than the scene"})
    controls.draw(name);
  ImGui::PopItemWidth();
}

}  // namespace qs
