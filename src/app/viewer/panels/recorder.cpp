// SPDX-License-Identifier: MIT
//
// The zoom recorder: curves of all modes while the camera approaches the point in its middle.
#include <iterator>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/hud_text.h"

namespace qs {
namespace {

ImVec4 color_of(CullMode mode) { return palette::with_opacity(on_dark::mode_color(mode)); }

void draw_curves(const ZoomRecording& zoom) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size{ImGui::GetContentRegionAvail().x, 11 * ImGui::GetFontSize()};
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddRectFilled(at, {at.x + size.x, at.y + size.y},
                     ImGui::GetColorU32({0.12f, 0.125f, 0.14f, 1}), 4);
  const ZoomCurves curves = zoom_curves(zoom);
  if (curves.longest_ms <= 0) return ImGui::Dummy(size);
  for (CullMode mode = 1; mode <= kCullerCount; ++mode) {
    std::vector<ImVec2> points;
    for (const glm::vec2 point : curves.modes[static_cast<std::size_t>(mode - 1)])
      points.emplace_back(at.x + 8 + point.x * (size.x - 16),
                          at.y + size.y - 6 - point.y * (size.y - 12));
    const ImU32 color = ImGui::GetColorU32(color_of(mode));
    draw.AddPolyline(points.data(), static_cast<int>(points.size()), color, 0, 2);
    for (const ImVec2& point : points) draw.AddCircleFilled(point, 2.5f, color);
  }
  draw.AddText({at.x + 8, at.y + 4}, ImGui::GetColorU32(palette::kFaint),
               fmt::format("{} ms", ms_text(curves.longest_ms)).c_str());
  ImGui::Dummy(size);
}

void draw_legend() {
  for (CullMode mode = 1; mode <= kCullerCount; ++mode) {
    if (mode > 1) ImGui::SameLine(0, 12);
    ImGui::TextColored(color_of(mode), "%s", mode_name(mode));
  }
}

}  // namespace

void draw_recorder(const Viewer& viewer, Actions& actions, float top) {
  const ZoomRecording& zoom = viewer.zoom;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({display.x - 10, top + 10}, ImGuiCond_FirstUseEver, {1, 0});
  ImGui::SetNextWindowSize({32 * ImGui::GetFontSize(), 0});
  bool open = true;
  ImGui::Begin("Zoom recorder", &open,
               ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::TextUnformatted(zoom_status(zoom).c_str());
  draw_curves(zoom);
  ImGui::TextColored(palette::kFaint, "ms per frame from far to near");
  draw_legend();
  if (ImGui::Button(zoom.running ? "Stop" : "Record"))
    actions.push_back(call(action::toggle_zoom_recorder));
  command_tooltip("Record a zoom");
  ImGui::End();
  if (!open) actions.push_back(call(action::toggle_panel, &Panels::recorder));
}

}  // namespace qs
