// SPDX-License-Identifier: MIT
#include "app/viewer/panels/panels.h"

#include <algorithm>
#include <span>

#include <glm/common.hpp>
#include <imgui.h>

#include "app/viewer/commands/commands.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

// A handle that is dragged to the left and right. Returns the mouse's x while it is dragged.
std::optional<float> draw_grip(const char* name, const Rect& area) {
  const auto mouse = draw_handle(name, area, ImGuiMouseCursor_ResizeEW);
  return mouse ? std::optional(mouse->x) : std::nullopt;
}

void draw_bar_panel(const PanelRow& row, const Viewer& viewer, PanelState& state,
                    Actions& actions) {
  bool open = true;
  ImGui::SetNextItemOpen(true, ImGuiCond_FirstUseEver);
  if (!(state.drawn.*row.open)) ImGui::SetScrollHereY(0);  // a panel that was opened is seen
  if (ImGui::CollapsingHeader(row.title, &open)) {
    ImGui::PushID(row.title);
    draw_blocks(row.blocks(viewer), viewer, state, actions);
    ImGui::PopID();
    ImGui::Spacing();
  }
  if (!open) actions.push_back(call(action::toggle_panel, row.open));
}

void draw_bar(const char* name, const Rect& area, std::span<bool Panels::*const> switches,
              const Viewer& viewer, PanelState& state, Actions& actions) {
  if (area.empty()) return;
  ImGui::SetNextWindowPos({area.low.x, area.low.y});
  ImGui::SetNextWindowSize({area.size().x, area.size().y});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::Begin(name, nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                   ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_NoBringToFrontOnFocus);
  for (bool Panels::*which : switches) {
    if (!(viewer.panels.*which)) continue;
    for (const PanelRow& row : state.rows)
      if (row.open == which) draw_bar_panel(row, viewer, state, actions);
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

// The bars, and the handles at their inner edges that change their widths.
void draw_bars(const Viewer& viewer, const Layout& layout, PanelState& state, Actions& actions) {
  draw_bar("left bar", layout.left, kLeftPanels, viewer, state, actions);
  // In a window too narrow for two bars, the left bar has all panels.
  if (layout.right.empty()) {
    draw_bar("left bar", layout.left, kRightPanels, viewer, state, actions);
  } else {
    draw_bar("right bar", layout.right, kRightPanels, viewer, state, actions);
  }
  const float letter = ImGui::GetFontSize(), half = 0.25f * letter;
  const auto edge = [&](const char* name, const Rect& bar, float x) {
    if (bar.empty()) return std::optional<float>();
    return draw_grip(name, {{x - half, bar.low.y}, {x + half, bar.high.y}});
  };
  if (const auto x = edge("left edge", layout.left, layout.left.high.x))
    actions.push_back(call(action::set_bar_width, &Bars::left, *x / letter));
  if (const auto x = edge("right edge", layout.right, layout.right.low.x)) {
    const float width = ImGui::GetIO().DisplaySize.x - *x;
    actions.push_back(call(action::set_bar_width, &Bars::right, width / letter));
  }
}

// Escape closes one thing: a menu or a dialog closes itself; then the help, the strip of first
// views, and what runs.
void use_escape(const Viewer& viewer, Actions& actions) {
  constexpr ImGuiPopupFlags kAny = ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel;
  if (!pressed(ImGuiKey_Escape) || ImGui::IsPopupOpen(nullptr, kAny) || ImGui::IsAnyItemActive())
    return;
  if (viewer.panels.help && viewer.panels.all) {
    actions.push_back(call(action::toggle_panel, &Panels::help));
  } else if (viewer.view_choice.pictures != nullptr) {
    actions.push_back(call(action::close_view_choice));
  } else {
    actions.push_back(call(action::cancel_running));
  }
}

}  // namespace

std::string fitted(std::string text, float width) {
  for (std::size_t most = letters_of(text); ImGui::CalcTextSize(text.c_str()).x > width && most > 8;
       --most)
    text = shortened_middle(text, most);
  return text;
}

void right_aligned(const std::string& text) {
  const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(text.c_str()).x;
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(0.0f, room));
  ImGui::TextUnformatted(text.c_str());
}

bool begin_dialog(const char* title, float width, float height, bool& open) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float em = ImGui::GetFontSize();
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize(
      {std::min(width * em, display.x - em), std::min(height * em, display.y - em)});
  return ImGui::BeginPopupModal(
      title, &open,
      ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize);
}

void tooltip_beside(const std::string& text) {
  const ImVec2 at = ImGui::GetWindowPos(), display = ImGui::GetIO().DisplaySize;
  const float letter = ImGui::GetFontSize();
  const float width = ImGui::GetWindowWidth(), room = display.x - width;
  const bool is_right = at.x + 0.5f * width > 0.5f * display.x;
  if (room > 12 * letter)
    ImGui::SetNextWindowPos({is_right ? at.x : at.x + width,
                             std::min(ImGui::GetItemRectMin().y, display.y - 9 * letter)},
                            ImGuiCond_Always, {is_right ? 1.0f : 0.0f, 0});
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(std::min(room, 40 * letter));
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void command_tooltip(const char* help) {
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", command_hint(help).c_str());
}

void same_line_if_fits(float width) {
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  const float end = ImGui::GetItemRectMax().x + ImGui::GetStyle().ItemSpacing.x + width;
  if (end <= right) ImGui::SameLine();
}

Layout current_layout(const Viewer& viewer) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  return layout_of(viewer, {{size.x, size.y}, ImGui::GetFontSize(), ImGui::GetFrameHeight()});
}

std::optional<glm::vec2> draw_handle(const char* name, const Rect& area, int cursor) {
  // A window of its own captures the mouse, so that dragging does not turn the camera.
  ImGui::SetNextWindowPos({area.low.x, area.low.y});
  ImGui::SetNextWindowSize({area.size().x, std::max(area.size().y, 1.0f)});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  ImGui::Begin(name, nullptr,
               kBareWindow | ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoMove);
  ImGui::InvisibleButton("grip", ImGui::GetContentRegionAvail());
  const bool active = ImGui::IsItemActive();
  if (active || ImGui::IsItemHovered()) ImGui::SetMouseCursor(cursor);
  ImGui::End();
  ImGui::PopStyleVar(2);
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  return active ? std::optional(glm::vec2(mouse.x, mouse.y)) : std::nullopt;
}

std::optional<float> draw_divider_line(const char* name, const Rect& picture, float x) {
  const float by = drawing_scale();
  const float grip = 14 * by;  // width in which the line can be dragged, screen units
  constexpr ImU32 kLight = IM_COL32(255, 255, 255, 230);
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  draw.AddLine({x, picture.low.y}, {x, picture.high.y}, IM_COL32(0, 0, 0, 160), 4 * by);
  draw.AddLine({x, picture.low.y}, {x, picture.high.y}, kLight, 1.5f * by);
  const ImVec2 middle{x, picture.center().y};
  draw.AddCircleFilled(middle, 13 * by, color_of(on_dark::kPanel), 32);
  draw.AddCircle(middle, 13 * by, kLight, 32, 1.5f * by);
  for (const float side : {-by, by})
    draw.AddTriangleFilled({x + 9 * side, middle.y}, {x + 4 * side, middle.y - 4.5f * side},
                           {x + 4 * side, middle.y + 4.5f * side}, kLight);
  return draw_grip(name, {{x - 0.5f * grip, picture.low.y}, {x + 0.5f * grip, picture.high.y}});
}

void draw_panels(const Viewer& viewer, PanelState& state, Actions& actions) {
  const Layout layout = current_layout(viewer);
  use_escape(viewer, actions);
  Floats floats(layout.picture);
  draw_overlay(viewer, state, floats, actions);
  draw_lost(viewer, floats);
  draw_heat_legend(viewer, state, floats, actions);
  draw_divider(viewer, floats, actions);
  draw_grid_labels(viewer, floats);
  draw_mode_plate(viewer, floats);
  if (viewer.panels.all) {
    draw_menu_bar(viewer, actions);
    draw_bars(viewer, layout, state, actions);
    if (viewer.panels.recorder && viewer.scene && !viewer.zoom.searched)
      actions.push_back(call(action::find_zooms));
    if (!layout.status.empty()) draw_status_line(viewer, layout.status);
    draw_hints(viewer, floats);
    draw_view_choice(viewer, state, floats, actions);
    draw_verdict(viewer, actions);
    // The help requests the focus in every frame, which would close a dialog.
    if (viewer.panels.help && !viewer.has_dialog()) draw_help(viewer, actions);
    if (!viewer.scene && !viewer.loading) draw_welcome(viewer, state, actions);
  }
  state.drawn = viewer.panels;
  draw_messages(viewer, floats, actions);
  const bool hovered = floats.draw();
  if (hovered != viewer.toasts_held) actions.push_back(call(action::hold_toasts, hovered));
  draw_open(viewer, state, actions);
  draw_train(viewer, state, actions);
  draw_palette(viewer, state, actions);
  draw_leaving(viewer, actions);
  // The arrow keys and Enter work in an open list or menu. Elsewhere keys are shortcuts.
  const bool has_list = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup) && !viewer.panels.open &&
                        !viewer.panels.train;
  ImGuiConfigFlags& flags = ImGui::GetIO().ConfigFlags;
  flags = has_list ? flags | ImGuiConfigFlags_NavEnableKeyboard
                   : flags & ~ImGuiConfigFlags_NavEnableKeyboard;
}

}  // namespace qs
