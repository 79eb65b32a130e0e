// SPDX-License-Identifier: MIT
//
// The grid of all modes: the name and the numbers of each mode below its picture.
#include <imgui.h>

#include "app/picture/grid_places.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/mode_glance.h"

namespace qs {
namespace {

// The leading parts of a label that fit into `room`; at least the first.
std::string fitting_label(std::string label, float room) {
  while (ImGui::CalcTextSize(label.c_str()).x > room) {
    const std::size_t end = label.rfind(" \u00b7 ");
    if (end == label.npos) break;
    label.resize(end);
  }
  return label;
}

}  // namespace

void draw_grid_labels(const Viewer& viewer) {
  if (!viewer.shown.grid) return;
  const Rect picture = current_layout(viewer).picture;
  const GridPlaces places = grid_places(culler_count(), kGridLabel);
  const float letter = ImGui::GetFontSize();
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const glm::vec2 share = places.low(mode - 1);
    const glm::vec2 low = picture.low + share * picture.size();
    const glm::vec2 end = low + places.side * picture.size();
    const ImU32 color = color_of(on_dark::mode_color(mode));
    const bool current = mode == viewer.mode();
    draw.AddRect({low.x, low.y}, {end.x, end.y}, color, 0, 0, current ? 3.0f : 1.0f);
    const float room = picture.size().x / static_cast<float>(places.columns);
    draw.PushClipRect({low.x, end.y}, {low.x + room, end.y + kGridLabel * picture.size().y}, true);
    draw.AddText({low.x, end.y + 0.2f * letter}, color, mode_name(mode));
    draw.AddText({low.x, end.y + 1.25f * letter}, ImGui::GetColorU32(palette::kText),
                 fitting_label(grid_label(viewer, mode), room - 0.5f * letter).c_str());
    draw.PopClipRect();
  }
}

}  // namespace qs
