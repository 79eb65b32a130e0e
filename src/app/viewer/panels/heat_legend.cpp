// SPDX-License-Identifier: MIT
//
// The legend of the map in the picture. It can be dragged and folded; a click on it opens the
// settings of heat maps.
#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <imgui.h>

#include "app/picture/grid_places.h"
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
  if (shown.heatmap) {
    const Heatmap& map = heatmap_at(viewer, viewer.cursor);
    const auto cell = cell_under_mouse(viewer, map.cell_px * shown.divisor, map.columns, map.rows);
    return LegendHere{heat_legend(viewer), cell && !shown.grid ? heat_text(shown, map, *cell) : ""};
  }
  if (!shown.values) return std::nullopt;
  const auto pixel =
      cell_under_mouse(viewer, shown.divisor, shown.values->width, shown.values->height);
  return LegendHere{make_legend(*shown.values, mode_name(shown.mode)),
                    pixel ? value_text(shown, *pixel) : ""};
}

// The middle of the legend's lower edge, inside the picture. `size`: of the legend.
glm::vec2 legend_place(const Viewer& viewer, const Rect& picture, glm::vec2 size) {
  const glm::vec2 usual{picture.center().x, picture.high.y - 12};
  const glm::vec2 wish = usual + viewer.heat_view.shift * ImGui::GetFontSize();
  const glm::vec2 low{picture.low.x + 0.5f * size.x, picture.low.y + size.y};
  const glm::vec2 high{picture.high.x - 0.5f * size.x, picture.high.y};
  return glm::max(low, glm::min(wish, high));
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
  const std::string text = fmt::format("fits {} in this view", mode_name(viewer.baseline));
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

// True if a whole legend below the grid of all modes would cover its labels.
bool hides_grid_labels(const Viewer& viewer, const Rect& picture) {
  constexpr float kLegendLetters = 5;  // height of a whole legend
  if (!viewer.shown.grid || viewer.heat_view.shift != glm::vec2(0)) return false;
  const GridPlaces places = grid_places(culler_count(), kGridLabel);
  const float end = places.label_top(culler_count() - 1) + kGridLabel;
  return (1 - end) * picture.size().y < kLegendLetters * ImGui::GetFontSize();
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

void draw_heat_legend(const Viewer& viewer, PanelState& state, Actions& actions) {
  const std::optional<LegendHere> here = legend_here(viewer);
  if (!here) return state.legend_drag.reset();
  const Legend& legend = here->legend;
  const Rect picture = current_layout(viewer).picture;
  const float width = std::min(picture.size().x - 20, 46 * ImGui::GetFontSize());
  const glm::vec2 place = legend_place(viewer, picture, state.legend_size);
  ImGui::SetNextWindowPos({place.x, place.y}, ImGuiCond_Always, {0.5f, 1});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::Begin("Heat map", nullptr,
               kBareWindow | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBringToFrontOnFocus);
  const bool narrow = hides_grid_labels(viewer, picture);
  if (!narrow) draw_fold_button(viewer, actions);
  ImGui::TextUnformatted(legend.title.c_str());
  const float shift = ImGui::CalcTextSize(here->under.c_str()).x;
  ImGui::SameLine(width - shift - ImGui::GetStyle().WindowPadding.x);
  ImGui::TextColored(palette::kAccent, "%s", here->under.c_str());
  if (!viewer.heat_view.folded && !narrow) {
    draw_color_bar(legend);
    ImGui::TextColored(palette::kFaint, "%s", legend.facts.c_str());
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", legend.facts.c_str());
  }
  if (drag_legend(viewer, state, actions) && viewer.shown.heatmap) ImGui::OpenPopup(kSettings);
  if (viewer.shown.heatmap) draw_heat_settings(viewer, actions);
  state.legend_size = {ImGui::GetWindowSize().x, ImGui::GetWindowSize().y};
  ImGui::End();
}

}  // namespace qs
