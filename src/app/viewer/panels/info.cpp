// SPDX-License-Identifier: MIT
//
// The scene's facts and the render settings.
#include <algorithm>

#include <fmt/format.h>
#include <glm/trigonometric.hpp>
#include <imgui.h>

#include "app/session/camera_control.h"
#include "app/session/text.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

void fact(const char* label, const std::string& value) {
  ImGui::TextColored(palette::kFaint, "%s", label);
  ImGui::SameLine(7 * ImGui::GetFontSize());
  ImGui::TextWrapped("%s", value.c_str());
}

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
        actions.push_back(action::ChangeBackend{choice});
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
  if (changed) actions.push_back(action::ChangeSettings{settings});
}

}  // namespace

void draw_info(const Viewer& viewer, Actions& actions, float top) {
  const ViewedScene& scene = *viewer.scene;
  const float width = 24 * ImGui::GetFontSize();
  ImGui::SetNextWindowPos({ImGui::GetIO().DisplaySize.x - width - 10, top + 10},
                          ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize({width, 0});
  bool open = true;
  ImGui::Begin("Scene and render settings", &open, ImGuiWindowFlags_NoNav);
  fact("file", scene.path.string());
  fact("format", scene.format);
  fact("Gaussians", grouped(scene.gaussians));
  fact("size", bytes_text(scene.file_bytes));
  fact("SH degree",
       fmt::format("{}{}", scene.sh_degree, scene.antialiased ? ", trained antialiased" : ""));
  fact("extent", fmt::format("{:.4g}", scene.extent()));
  fact("cameras", scene.cameras.empty()
                      ? std::string("none: drop a cameras.json on the window")
                      : fmt::format("{}, {} with a photograph", scene.cameras.size(),
                                    scene.photographs.size()));
  const glm::dvec3 at = viewer.camera.position();
  fact("view", fmt::format("from {:.3g}, {:.3g}, {:.3g}", at.x, at.y, at.z));
  fact("lens", fmt::format("{:.1f} degrees, near plane {:.3g}",
                           glm::degrees(vertical_fov(viewer.camera)), viewer.camera.near_depth));
  ImGui::Separator();
  draw_settings(viewer, actions);
  ImGui::End();
  if (!open) actions.push_back(action::TogglePanel{&Panels::info});
}

}  // namespace qs
