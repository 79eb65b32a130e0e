// SPDX-License-Identifier: MIT
#include "app/viewer/panels/color_bar.h"

#include <imgui.h>

#include "app/viewer/panels/style.h"

namespace qs {

void draw_color_bar(const std::function<glm::vec3(float)>& color,
                    const std::vector<BarTick>& ticks) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float width = ImGui::GetContentRegionAvail().x, height = 0.9f * ImGui::GetFontSize();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  constexpr int kSteps = 64;
  const auto packed = [&](int step) {
    const glm::vec3 c = color(static_cast<float>(step) / kSteps);
    return ImGui::GetColorU32({c.x, c.y, c.z, 1});
  };
  for (int i = 0; i < kSteps; ++i) {
    const float left = at.x + width * static_cast<float>(i) / kSteps;
    const float right = at.x + width * static_cast<float>(i + 1) / kSteps;
    draw.AddRectFilledMultiColor({left, at.y}, {right, at.y + height}, packed(i), packed(i + 1),
                                 packed(i + 1), packed(i));
  }
  // From the right, because the last text has the unit; a text that would touch it is left out.
  float free_until = at.x + width;
  for (std::size_t i = ticks.size(); i-- > 0;) {
    const BarTick& tick = ticks[i];
    const float x = at.x + width * tick.at;
    const float text = ImGui::CalcTextSize(tick.text.c_str()).x;
    const bool first = i == 0, last = i + 1 == ticks.size();
    const float left = first ? x : last ? x - text : x - 0.5f * text;
    draw.AddLine({x, at.y + height}, {x, at.y + height + 4}, ImGui::GetColorU32(palette::kFaint));
    if (left + text > free_until && !last) continue;
    draw.AddText({left, at.y + height + 5}, ImGui::GetColorU32(palette::kText), tick.text.c_str());
    free_until = left - 0.5f * ImGui::GetFontSize();
  }
  ImGui::Dummy({width, height + 6 + ImGui::GetTextLineHeight()});
}

}  // namespace qs
