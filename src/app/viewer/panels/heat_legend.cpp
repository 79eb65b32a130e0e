// SPDX-License-Identifier: MIT
//
// The legend of the map in the picture. It can be dragged and folded; a click on it opens the
// settings of heat maps.
#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

constexpr const char* kSettings = "settings of heat maps";

// The legend of the picture, and the value under the cursor.
struct LegendHere {
  Legend legend;
  std::string under;
};

// The cell of a map under the mouse; unset over a panel.
std::optional<std::size_t> cell_under_mouse(const Viewer& viewer, int cell_px, int columns,
                                            int rows) {
  if (ImGui::GetIO().WantCaptureMouse) return std::nullopt;
  return cell_under_cursor(viewer, cell_px, columns, rows);
}

std::optional<LegendHere> legend_here(const Viewer& viewer) {
  const ShownFrame& shown = viewer.shown;
  if (awaited_map(viewer)) {
    Legend legend;
    legend.title = awaited_title(viewer);
    return LegendHere{legend, kComputing};
  }
  if (shown.heatmap) {
    const Heatmap& map = heatmap_at(viewer, viewer.cursor);
    const auto cell = cell_under_mouse(viewer, map.cell_px * shown.divisor, map.columns, map.rows);
    LegendHere here{heat_legend(viewer), cell ? heat_text(shown, map, *cell) : ""};
    if (shown.grid) {
      here.under = scale_text(viewer);
      here.legend.facts.clear();
    }
    return here;
  }
  if (!shown.values) return std::nullopt;
  const auto pixel =
      cell_under_mouse(viewer, shown.divisor, shown.values->width, shown.values->height);
  return LegendHere{make_legend(*shown.values, mode_name(shown.mode)),
                    pixel ? value_text(shown, *pixel) : ""};
}

// Moves the legend while it is dragged. Returns true after a click.
bool drag_legend(const Viewer& viewer, PanelState& state, Actions& actions) {
  constexpr float kClick = 4;  // screen units: a shorter drag is a click
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsWindowHovered() && !ImGui::IsAnyItemHovered() &&
      ImGui::IsMouseClicked(ImGuiMouseButton_Left))
    state.legend_drag = 0;
  if (!state.legend_drag) return false;
  *state.legend_drag += std::abs(io.MouseDelta.x) + std::abs(io.MouseDelta.y);
  const bool drags = *state.legend_drag > kClick;
  if (drags && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)) {
    HeatView view = viewer.heat_view;
    view.shift += glm::vec2(io.MouseDelta.x, io.MouseDelta.y) / ImGui::GetFontSize();
    actions.push_back(call(action::change_heat_view, view));
  }
  if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) return false;
  state.legend_drag.reset();
  return !drags;
}

void choose_maximum(const Viewer& viewer, HeatView& view) {
  bool fits = view.maximum == 0;
  const std::string text = fmt::format("fits {} in this view", mode_name(mode_of_scale(viewer)));
  const auto shown = static_cast<int>(viewer.shown.map_scale.maximum);
  if (ImGui::Checkbox(text.c_str(), &fits))
    view.maximum = fits ? 0 : static_cast<std::uint32_t>(shown);
  int typed = shown;
  ImGui::SetNextItemWidth(9 * ImGui::GetFontSize());
  if (ImGui::InputInt("maximum", &typed, 0, 0, ImGuiInputTextFlags_EnterReturnsTrue))
    view.maximum = static_cast<std::uint32_t>(std::max(typed, 1));
}

void draw_heat_settings(const Viewer& viewer, Actions& actions) {
  if (!ImGui::BeginPopup(kSettings)) return;
  if (pressed(ImGuiKey_Escape)) ImGui::CloseCurrentPopup();
  const ControlsDrawer controls(viewer, actions);
  controls.draw_radio("Heat map", false);
  ImGui::Separator();
  controls.draw({"opacity over the colours", 9});
  controls.draw({"colour map", 0, false, block::Form::radio});
  ImGui::Separator();
  HeatView view = viewer.heat_view;
  choose_maximum(viewer, view);
  if (view != viewer.heat_view) actions.push_back(call(action::change_heat_view, view));
  ImGui::EndPopup();
}

void draw_fold_button(const Viewer& viewer, Actions& actions) {
  const bool folded = viewer.heat_view.folded;
  if (ImGui::ArrowButton("fold", folded ? ImGuiDir_Right : ImGuiDir_Down)) {
    HeatView view = viewer.heat_view;
    view.folded = !folded;
    actions.push_back(call(action::change_heat_view, view));
  }
  ImGui::SameLine();
}

// `whole`: with the bar and the facts; else a line.
void draw_legend_window(const Viewer& viewer, const LegendHere& here, const Rect& place, bool whole,
                        PanelState& state, Actions& actions) {
  const Legend& legend = here.legend;
  ImGui::SetNextWindowPos({place.low.x, place.low.y});
  ImGui::SetNextWindowSize({place.size().x, place.size().y});
  ImGui::Begin("Heat map", nullptr,
               kBareWindow | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBringToFrontOnFocus);
  if (whole || viewer.heat_view.folded) draw_fold_button(viewer, actions);
  const float value = ImGui::CalcTextSize(here.under.c_str()).x;
  const float right = place.size().x - value - ImGui::GetStyle().WindowPadding.x;
  const auto is_beside_value = [&](const std::string& text) {
    return ImGui::GetCursorPosX() + ImGui::CalcTextSize(text.c_str()).x < right;
  };
  ImGui::TextUnformatted(fitting_parts(legend.title, " ", is_beside_value).c_str());
  ImGui::SameLine(right);
  ImGui::TextColored(palette::kAccent, "%s", here.under.c_str());
  if (whole) {
    if (legend.color) draw_color_bar(legend);
    if (!legend.facts.empty()) draw_wrapped(palette::kFaint, legend.facts);
  }
  if (drag_legend(viewer, state, actions) && viewer.shown.heatmap) ImGui::OpenPopup(kSettings);
  if (viewer.shown.heatmap) draw_heat_settings(viewer, actions);
  ImGui::End();
}

}  // namespace

void draw_heat_scale_menu(const Viewer& viewer, Actions& actions) {
  if (!ImGui::BeginMenu("Scale of the heat map", viewer.shown.heatmap.has_value())) return;
  HeatView view = viewer.heat_view;
  choose_maximum(viewer, view);
  ImGui::Separator();
  for (std::size_t i = 0; i < std::size(kHeatColors); ++i) {
    const auto colors = static_cast<HeatColors>(i);
    if (ImGui::MenuItem(kHeatColors[i], nullptr, view.style.colors == colors))
      view.style.colors = colors;
  }
  if (view != viewer.heat_view) actions.push_back(call(action::change_heat_view, view));
  ImGui::EndMenu();
}

void draw_heat_legend(const Viewer& viewer, PanelState& state, Floats& floats, Actions& actions) {
  const std::optional<LegendHere> here = legend_here(viewer);
  if (!here) return state.legend_drag.reset();
  // The maps of the grid are parts of its pictures.
  if (viewer.shown.grid && awaited_map(viewer)) {
    const auto [low, high] = floats.picture();
    ImGui::GetBackgroundDrawList()->AddRectFilled({low.x, low.y}, {high.x, high.y},
                                                  color_of(on_dark::kPanel, 0.8f));
  }
  const ImGuiStyle& style = ImGui::GetStyle();
  const float letter = ImGui::GetFontSize(), width = std::min(floats.room(), 46 * letter);
  const glm::vec2 line(width, ImGui::GetFrameHeight() + 2 * style.WindowPadding.y);
  const ImVec2 facts = ImGui::CalcTextSize(here->legend.facts.c_str(), nullptr, false,
                                           width - 2 * style.WindowPadding.x);
  const float bar = here->legend.color ? color_bar_height() + style.ItemSpacing.y : 0;
  const float words = here->legend.facts.empty() ? 0 : style.ItemSpacing.y + facts.y;
  const glm::vec2 whole = line + glm::vec2(0, bar + words);
  Floating legend{FloatKind::legend, viewer.heat_view.folded ? line : whole, line};
  if (viewer.heat_view.shift != glm::vec2(0)) {
    const Rect& picture = floats.picture();
    legend.at = glm::vec2(picture.center().x, picture.high.y) + viewer.heat_view.shift * letter;
  }
  floats.add(legend, [&viewer, &state, &actions, here = *here, line](const Rect& place) {
    draw_legend_window(viewer, here, place, place.size().y > line.y + 1, state, actions);
  });
}

}  // namespace qs
