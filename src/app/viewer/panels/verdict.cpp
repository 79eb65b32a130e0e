// SPDX-License-Identifier: MIT
//
// The verdict of the fp64 reference. It stays until the user closes it or the view changes.
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {

void draw_verdict(const Viewer& viewer, Actions& actions) {
  if (!verdict_is_current(viewer)) return;
  const std::optional<glm::ivec2>& pixel = viewer.comparison->verdict.difference.first;
  const Rect picture = current_layout(viewer).picture;
  ImGui::SetNextWindowPos({picture.low.x + 10, picture.high.y - 10}, ImGuiCond_Appearing, {0, 1});
  bool open = true;
  ImGui::Begin("Reference", &open,
               ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse);
  for (const Fact& fact : verdict_facts(*viewer.comparison)) {
    ImGui::TextColored(palette::kFaint, "%s", fact.label.c_str());
    ImGui::SameLine(7 * ImGui::GetFontSize());
    const bool failed = pixel && fact.label == "verdict";
    ImGui::TextColored(failed ? palette::kError : palette::kText, "%s", fact.value.c_str());
  }
  if (pixel && ImGui::Button("Inspect this pixel")) {
    if (!viewer.panels.inspector) actions.push_back(call(action::toggle_panel, &Panels::inspector));
    actions.push_back(call(action::inspect_pixel, glm::dvec2(*pixel)));
  }
  ImGui::End();
  if (!open) actions.push_back(call(action::dismiss_comparison));
}

}  // namespace qs
