// SPDX-License-Identifier: MIT
//
// Words over the picture: the names and numbers of the grid of all modes; the mode's name after a
// switch, with the numbers that changed, or as a badge that stays; the names of the sides of a
// split window, with its divider; and the way back to the scene in a view that shows next to
// nothing.
#include <algorithm>

#include <glm/common.hpp>
#include <imgui.h>

#include "app/picture/grid_places.h"
#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/lost.h"
#include "app/viewer/state/mode_table.h"

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

// The name of each variant over its part of the picture.
void draw_names(const Viewer& viewer, const Rect& picture, float x) {
  const Split& split = viewer.split;
  const auto [left, right] = split_names(viewer);
  const float letter = ImGui::GetFontSize();
  const bool legend_below = viewer.shown.heatmap.has_value();
  const float y = legend_below ? picture.low.y + 0.8f * letter : picture.high.y - 3.4f * letter;
  if (split.view == SplitView::sides) {
    const float gap = 10 * drawing_scale();
    draw_plate(left, x - gap, y, 1);
    draw_plate(right, x + gap, y, 0);
  } else if (split.view == SplitView::whole) {
    draw_plate(left, picture.center().x, y, 0.5f);
  }
}

// An arrow whose tip is at `tip`.
void draw_arrow(ImDrawList& draw, glm::vec2 tip, glm::vec2 direction, float size) {
  const glm::vec2 aside(-direction.y, direction.x);
  const auto at = [&](float back, float side) {
    const glm::vec2 place = tip - back * size * direction + side * size * aside;
    return ImVec2(place.x, place.y);
  };
  const ImVec2 outline[] = {at(0, 0),        at(1, 0.8f),  at(1, 0.3f), at(2.2f, 0.3f),
                            at(2.2f, -0.3f), at(1, -0.3f), at(1, -0.8f)};
  const float by = drawing_scale();
  draw.AddTriangleFilled(outline[0], outline[1], outline[6], color_of(kSkyBlue));
  draw.AddQuadFilled(at(0.9f, 0.3f), outline[3], outline[4], at(0.9f, -0.3f), color_of(kSkyBlue));
  draw.AddPolyline(outline, 7, IM_COL32(0, 0, 0, 200), ImDrawFlags_Closed, 1.5f * by);
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

void draw_divider(const Viewer& viewer, Actions& actions) {
  if (!viewer.shown.other) return;
  const Rect picture = current_layout(viewer).picture;
  const float x = picture.low.x + viewer.split.divider * picture.size().x;
  draw_names(viewer, picture, x);
  if (viewer.split.view != SplitView::sides) return;
  if (const auto mouse = draw_divider_line("divider", picture, x)) {
    const float divider = std::clamp((*mouse - picture.low.x) / picture.size().x, 0.0f, 1.0f);
    if (divider != viewer.split.divider)
      ControlsDrawer(viewer, actions).set("divider", static_cast<double>(divider));
  }
}

void draw_lost(const Viewer& viewer) {
  const auto way = way_to_subject(viewer);
  const Rect picture = current_layout(viewer).picture;
  if (!way || picture.empty()) return;
  const float letter = ImGui::GetFontSize();
  const glm::vec2 per_pixel = picture.size() / glm::vec2(viewer.camera.width, viewer.camera.height);
  const glm::vec2 tip = picture.low + (glm::vec2(way->tip) + 0.5f) * per_pixel;
  const glm::vec2 direction(way->direction);
  const float size = 1.4f * letter;  // of the arrow's head
  draw_arrow(*ImGui::GetBackgroundDrawList(), tip, direction, size);
  // The words are behind the arrow, inside of the picture.
  const ImVec2 text = ImGui::CalcTextSize(kWayBack);
  const glm::vec2 plate = glm::vec2(text.x, text.y) + glm::vec2(16, 8) * drawing_scale();
  const glm::vec2 tail = tip - (2.2f * size + 0.7f * letter) * direction;
  const glm::vec2 center = tail - 0.5f * plate * direction;
  const glm::vec2 most = glm::max(picture.high - plate, picture.low);
  const glm::vec2 low = glm::clamp(center - 0.5f * plate, picture.low, most);
  draw_plate(kWayBack, low.x, low.y, 0);
}

}  // namespace qs
