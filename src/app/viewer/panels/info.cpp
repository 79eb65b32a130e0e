// SPDX-License-Identifier: MIT
//
// The scene's facts and the render settings.
#include <algorithm>

#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

void draw_settings(const Viewer& viewer, Actions& actions) {
  RenderSettings settings = viewer.settings;
  bool changed = false;
  ImGui::PushItemWidth(9 * ImGui::GetFontSize());
  int sh_degree = std::min(settings.sh_degree, viewer.scene->sh_degree);
  if (ImGui::SliderInt("SH degree", &sh_degree, 0, viewer.scene->sh_degree)) {
    settings.sh_degree = sh_degree;
    changed = true;
  }
  changed |= ImGui::SliderFloat("splat scale", &settings.splat_scale, 0.01f, 3, "%.2f",
                                ImGuiSliderFlags_Logarithmic);
  command_tooltip("Larger splats");
  changed |= ImGui::ColorEdit3("background", &settings.background.x, ImGuiColorEditFlags_NoInputs);
  int antialias = settings.antialiased ? (*settings.antialiased ? 1 : 2) : 0;
  if (ImGui::Combo("antialias", &antialias, "as trained\0on\0off\0")) {
    settings.antialiased = antialias == 0 ? std::nullopt : std::optional(antialias == 1);
    changed = true;
  }
  int backend = static_cast<int>(viewer.backend);
  const auto available = available_backends();
  if (ImGui::BeginCombo("backend", kBackendNames[backend])) {
    for (const Backend choice : available) {
      if (ImGui::Selectable(kBackendNames[static_cast<int>(choice)], choice == viewer.backend))
        actions.push_back(call(action::change_backend, choice));
    }
    ImGui::EndCombo();
  }
  if (pipelines_of(viewer.backend).size() > 1) {
    int pipeline = static_cast<int>(settings.pipeline);
    if (ImGui::Combo("pipeline", &pipeline, kPipelineNames, 2)) {
      settings.pipeline = static_cast<Pipeline>(pipeline);
      changed = true;
    }
  }
  ImGui::PopItemWidth();
  bool skips_huge = viewer.skips_huge;
  if (viewer.scene->huge + viewer.scene->skipped_huge > 0 &&
      ImGui::Checkbox("leave out what is larger than the scene", &skips_huge))
    actions.push_back(call(action::skip_huge, skips_huge));
  if (changed) actions.push_back(call(action::change_settings, settings));
}

}  // namespace

void draw_info(const Viewer& viewer, PanelState&, Actions& actions) {
  for (const Fact& fact : scene_facts_of(viewer)) draw_fact(fact);
  ImGui::Separator();
  draw_settings(viewer, actions);
}

}  // namespace qs
