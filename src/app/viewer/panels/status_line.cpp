// SPDX-License-Identifier: MIT
//
// The line below the picture.
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/hud_text.h"

namespace qs {

void draw_status_line(const Viewer& viewer, const Rect& area) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  draw.AddRectFilled({area.low.x, area.low.y}, {area.high.x, area.high.y},
                     ImGui::GetColorU32(ImGuiCol_MenuBarBg));
  if (!viewer.scene && !viewer.loading) return;
  const float letter = ImGui::GetFontSize();
  const float y = area.center().y - 0.5f * letter;
  const StatusLine line = status_line(viewer);
  const float note = area.high.x - ImGui::CalcTextSize(line.note.c_str()).x - 0.8f * letter;
  draw.PushClipRect({area.low.x, area.low.y}, {note - letter, area.high.y}, true);
  draw.AddText({area.low.x + 0.8f * letter, y},
               ImGui::GetColorU32(line.faint ? palette::kFaint : palette::kText),
               line.numbers.c_str());
  draw.PopClipRect();
  draw.AddText({note, y}, ImGui::GetColorU32(line.caution ? palette::kCaution : palette::kFaint),
               line.note.c_str());
}

}  // namespace qs
