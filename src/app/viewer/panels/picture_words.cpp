// SPDX-License-Identifier: MIT
//
// Words over the picture: the names and numbers of the grid of all modes; the mode's name after a
// switch, with the numbers that changed, or as a badge that stays; the names of the sides of a
// split window, with its divider; and the way back to the scene in a view that shows next to
// nothing.
#include <algorithm>

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
std::string fitting_label(const std::string& label, const char* separator, float room) {
  return fitting_parts(label, separator, [room](const std::string& text) {
    return ImGui::CalcTextSize(text.c_str()).x <= room;
  });
}

// The mode's name in its colour and `size`, above lines of text. `align`: of the lines, 0 left, 0.5
// centre.
void draw_mode_words(CullMode mode, const std::vector<std::string>& lines, const Rect& place,
                     float align, float size) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  ImFont* font = ImGui::GetFont();
  const float letter = ImGui::GetFontSize(), padding = 0.5f * letter;
  const char* name = mode_name(mode);
  const ImVec2 low{place.low.x, place.low.y}, high{place.high.x, place.high.y};
  const ImU32 color = ImGui::GetColorU32(palette::text_of(ink_of(mode)));
  // Opaque: over a white picture the colour of a mode has too little contrast.
  draw.AddRectFilled(low, high, ImGui::GetColorU32(palette::kPanel), 0.3f * letter);
  draw.AddRectFilled(low, {low.x + 0.25f * letter, high.y}, color, 0.1f * letter);
  const auto x_of = [&](float text_width) {
    return low.x + padding + align * (place.size().x - 2 * padding - text_width);
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

void add_mode_words(Floats& floats, FloatKind kind, CullMode mode, std::vector<std::string> lines,
                    float align, float size) {
  const float letter = ImGui::GetFontSize();
  float width = ImGui::GetFont()->CalcTextSizeA(size, FLT_MAX, 0, mode_name(mode)).x;
  for (std::string& line : lines) {
    line = fitting_label(line, ", ", floats.room() - letter);
    width = std::max(width, ImGui::CalcTextSize(line.c_str()).x);
  }
  const float height =
      size + static_cast<float>(lines.size()) * ImGui::GetTextLineHeightWithSpacing();
  floats.add({kind, glm::vec2(width, height) + letter},
             [=](const Rect& place) { draw_mode_words(mode, lines, place, align, size); });
}

// The name of each variant over its part of the picture.
void add_names(const Viewer& viewer, Floats& floats, float x) {
  const Split& split = viewer.split;
  const auto [left, right] = split_names(viewer);
  const float y = floats.picture().low.y, gap = 10 * drawing_scale();
  if (split.view == SplitView::sides) {
    floats.add_plate(FloatKind::left_name, left, glm::vec2(x - gap, y));
    floats.add_plate(FloatKind::right_name, right, glm::vec2(x + gap, y));
  } else if (split.view == SplitView::whole) {
    floats.add_plate(FloatKind::name, left);
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

void draw_grid_labels(const Viewer& viewer, Floats& floats) {
  if (!viewer.shown.grid) return;
  const Rect& picture = floats.picture();
  const GridPlaces places = grid_places(culler_count(), kGridLabel);
  const float letter = ImGui::GetFontSize();
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const glm::vec2 low = picture.low + places.low(mode - 1) * picture.size();
    const glm::vec2 end = low + places.side * picture.size();
    const ImU32 color = color_of(on_dark::mode_color(mode));
    draw.AddRect({low.x, low.y}, {end.x, end.y}, color, 0, 0, mode == viewer.mode() ? 3.0f : 1.0f);
    floats.add({FloatKind::cell, end - low, {}, low}, {});
    const float column = picture.size().x / static_cast<float>(places.columns);
    const float room = std::min(column - letter, picture.high.x - low.x);
    const float height = std::min(kGridLabel * picture.size().y, 2.25f * letter);
    // In a low window the name and the numbers are in one line.
    const bool is_low = height < 2.25f * letter;
    const std::string name = mode_name(mode);
    const float name_width = is_low ? ImGui::CalcTextSize(name.c_str()).x + 0.6f * letter : 0;
    const std::string label =
        fitting_label(grid_label(viewer, mode), " \u00b7 ", room - name_width);
    const float width = ImGui::CalcTextSize(label.c_str()).x;
    floats.add({FloatKind::caption, {room, is_low ? 1.1f * letter : height}, {}, {{low.x, end.y}}},
               [=](const Rect& place) {
                 ImDrawList& words = *ImGui::GetBackgroundDrawList();
                 const float y = place.low.y + (is_low ? 0 : 0.2f * letter);
                 words.PushClipRect({low.x, place.low.y}, {place.high.x, place.high.y}, true);
                 words.AddText({low.x, y}, color, name.c_str());
                 if (!is_low || name_width + width <= room)
                   words.AddText({low.x + name_width, is_low ? y : y + 1.05f * letter},
                                 color_of(on_dark::kText), label.c_str());
                 words.PopClipRect();
               });
  }
}

void draw_mode_plate(const Viewer& viewer, Floats& floats) {
  if (!viewer.scene) return;
  const float letter = ImGui::GetFontSize();
  if (viewer.mode_switch && viewer.panels.all) {
    std::vector<std::string> lines;
    if (const std::string text = switch_text(viewer); !text.empty()) lines.push_back(text);
    add_mode_words(floats, FloatKind::plate, viewer.mode_switch->to, lines, 0.5f, 1.6f * letter);
  } else if (viewer.shows_badge) {
    add_mode_words(floats, FloatKind::badge, viewer.mode(), badge_lines(viewer), 0, letter);
  }
}

void draw_divider(const Viewer& viewer, Floats& floats, Actions& actions) {
  if (!viewer.shown.other) return;
  const Rect& picture = floats.picture();
  const float x = picture.low.x + viewer.split.divider * picture.size().x;
  add_names(viewer, floats, x);
  if (viewer.split.view != SplitView::sides) return;
  if (const auto mouse = draw_divider_line("divider", picture, x)) {
    const float divider = std::clamp((*mouse - picture.low.x) / picture.size().x, 0.0f, 1.0f);
    if (divider != viewer.split.divider)
      ControlsDrawer(viewer, actions).set("divider", static_cast<double>(divider));
  }
}

void draw_lost(const Viewer& viewer, Floats& floats) {
  const auto way = way_to_subject(viewer);
  const Rect& picture = floats.picture();
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
  floats.add_plate(FloatKind::way, kWayBack, tail - 0.5f * plate * direction);
}

}  // namespace qs
