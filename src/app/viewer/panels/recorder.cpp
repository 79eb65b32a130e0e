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
  const float letter = ImGui::GetFontSize();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size{ImGui::GetContentRegionAvail().x, 12 * letter};
  const ZoomCurves curves = zoom_curves(zoom);
  if (curves.longest_ms <= 0) return;
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImU32 faint = ImGui::GetColorU32(palette::kFaint), line = IM_COL32(255, 255, 255, 28);
  const ImVec2 low{at.x + 4 * letter, at.y + 0.5f * letter};
  const ImVec2 high{at.x + size.x - 0.5f * letter, at.y + size.y - 1.6f * letter};
  const auto place = [&](glm::vec2 point) {
    return ImVec2(low.x + point.x * (high.x - low.x), high.y - point.y * (high.y - low.y));
  };
  for (const float share : {0.0f, 0.5f, 1.0f}) {
    const float y = place({0, share}).y;
    const std::string text = ms_text(static_cast<double>(share) * curves.longest_ms);
    draw.AddLine({low.x, y}, {high.x, y}, line);
    draw.AddText({low.x - ImGui::CalcTextSize(text.c_str()).x - 6, y - 0.5f * letter}, faint,
                 text.c_str());
  }
  draw.AddText({low.x, high.y + 0.3f * letter}, faint, "far");
  draw.AddText({high.x - ImGui::CalcTextSize("near").x, high.y + 0.3f * letter}, faint, "near");
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    std::vector<ImVec2> points;
    for (const glm::vec2 point : curves.modes[static_cast<std::size_t>(mode - 1)])
      points.push_back(place(point));
    const ImU32 color = ImGui::GetColorU32(color_of(mode));
    draw.AddPolyline(points.data(), static_cast<int>(points.size()), color, 0, 2);
    for (const ImVec2& point : points) draw.AddCircleFilled(point, 2.5f, color);
  }
  ImGui::Dummy(size);
}

void draw_mode_legend() {
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    if (mode > 1) same_line_if_fits(ImGui::CalcTextSize(mode_name(mode)).x);
    ImGui::TextColored(color_of(mode), "%s", mode_name(mode));
  }
}

}  // namespace

void draw_recorder(const Viewer& viewer, PanelState&, Actions& actions) {
  const ZoomRecording& zoom = viewer.zoom;
  ImGui::TextWrapped("%s", zoom_status(zoom).c_str());
  draw_curves(zoom);
  ImGui::TextColored(palette::kFaint, "milliseconds per frame");
  draw_mode_legend();
  if (ImGui::Button(zoom.running ? "Stop" : "Record"))
    actions.push_back(call(action::toggle_zoom_recorder));
  command_tooltip("Record a zoom");
}

}  // namespace qs
