// SPDX-License-Identifier: MIT
//
// The mode over the picture: after a switch its name with the numbers that changed, or a badge that
// stays.
#include <algorithm>

#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/mode_glance.h"

namespace qs {
namespace {

// The mode's name in its colour and `size`, above lines of text. `align`: 0 left, 0.5 centre of
// `x`.
void draw_mode_words(CullMode mode, const std::vector<std::string>& lines, glm::vec2 at,
                     float align, float size) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  ImFont* font = ImGui::GetFont();
  const float letter = ImGui::GetFontSize(), padding = 0.5f * letter;
  const char* name = mode_name(mode);
  float width = font->CalcTextSizeA(size, FLT_MAX, 0, name).x;
  for (const std::string& line : lines)
    width = std::max(width, ImGui::CalcTextSize(line.c_str()).x);
  const float height =
      size + static_cast<float>(lines.size()) * ImGui::GetTextLineHeightWithSpacing();
  const ImVec2 low{at.x - align * (width + 2 * padding), at.y};
  const ImVec2 high{low.x + width + 2 * padding, low.y + height + 2 * padding};
  const ImU32 color = color_of(on_dark::mode_color(mode));
  draw.AddRectFilled(low, high, ImGui::GetColorU32(palette::with_opacity(on_dark::kPanel, 0.85f)),
                     0.3f * letter);
  draw.AddRectFilled(low, {low.x + 0.25f * letter, high.y}, color, 0.1f * letter);
  const auto x_of = [&](float text_width) {
    return low.x + padding + align * (width - text_width);
  };
  float y = low.y + padding;
  draw.AddText(font, size, {x_of(font->CalcTextSizeA(size, FLT_MAX, 0, name).x), y}, color, name);
  y += size + 0.5f * ImGui::GetStyle().ItemSpacing.y;
  for (const std::string& line : lines) {
    draw.AddText({x_of(ImGui::CalcTextSize(line.c_str()).x), y}, ImGui::GetColorU32(palette::kText),
                 line.c_str());
    y += ImGui::GetTextLineHeightWithSpacing();
  }
}

}  // namespace

void draw_mode_plate(const Viewer& viewer) {
  if (!viewer.scene) return;
  const Rect picture = current_layout(viewer).picture;
  const float letter = ImGui::GetFontSize();
  if (viewer.mode_switch && viewer.panels.all) {
    std::vector<std::string> lines;
    if (const std::string text = switch_text(viewer); !text.empty()) lines.push_back(text);
    draw_mode_words(viewer.mode_switch->to, lines,
                    {picture.center().x, picture.low.y + 0.8f * letter}, 0.5f, 1.6f * letter);
  } else if (viewer.shows_badge) {
    draw_mode_words(viewer.mode(), badge_lines(viewer),
                    {picture.low.x + 0.8f * letter, picture.low.y + 0.8f * letter}, 0, letter);
  }
}

}  // namespace qs
