// SPDX-License-Identifier: MIT
//
// The split window: the divider between the view and another variant of it or another scene, and
// the panel that chooses the other side and shows the differences.
#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/color_bar.h"
#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/hud_text.h"

namespace qs {
namespace {

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

// Closes the second scene, or chooses another variant.
void choose_what_is_beside(const Viewer& viewer, const ControlsDrawer& controls, Actions& actions) {
  if (viewer.beside) {
    const auto [first, second] = names_of_scenes(viewer, *viewer.beside);
    ImGui::TextWrapped("%s beside %s, both %s", first.c_str(), second.c_str(),
                       full_name(viewer.variant()).c_str());
    if (ImGui::Button("Close the scene beside")) actions.push_back(call(action::toggle_beside));
    command_tooltip("Open or close a scene beside");
    return;
  }
  ImGui::AlignTextToFramePadding();
  ImGui::Text("%s beside", name_beside(viewer.variant(), viewer.split.other).c_str());
  const float letter = ImGui::GetFontSize();
  same_line_if_fits(10 * letter);
  ImGui::SetNextItemWidth(10 * letter);
  controls.draw("beside", "");
  ImGui::SetNextItemWidth(10 * letter);
  controls.draw("drawn by");
}

// The scale of the map of pair differences and its value under the cursor.
void draw_pair_legend(const Viewer& viewer) {
  const PairDifference& pairs = *viewer.shown.other->pairs;
  draw_color_bar(pair_legend(viewer.shown));
  const auto tile = cell_under_mouse(viewer, pairs.grid.tile_px * viewer.shown.divisor,
                                     pairs.grid.columns, pairs.grid.rows);
  const std::string under = tile ? signed_text(pairs.values[*tile]) : "-";
  ImGui::PushStyleColor(ImGuiCol_Text, palette::kFaint);
  ImGui::TextWrapped("%s; here: %s", kPairColors, under.c_str());
  ImGui::PopStyleColor();
}

}  // namespace

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

void draw_split(const Viewer& viewer, PanelState&, Actions& actions) {
  const ControlsDrawer controls(viewer, actions);
  choose_what_is_beside(viewer, controls, actions);
  controls.draw_radio_buttons("view");
  ImGui::SetNextItemWidth(9 * ImGui::GetFontSize());
  controls.draw("differences times");
  controls.draw("Flip");
  ImGui::Separator();
  if (viewer.shown.other) {
    if (viewer.split.view == SplitView::tile_pairs && viewer.shown.other->pairs)
      draw_pair_legend(viewer);
    if (viewer.split.view == SplitView::difference)
      draw_color_bar(difference_legend(shown_amplification(viewer)));
    for (const Fact& fact : split_facts(viewer)) draw_fact(fact);
  } else if (viewer.split.other.mode == kReferenceMode) {
    ImGui::TextWrapped(
        "0 computes the reference of this view, which takes seconds; Shift+0 only what is around "
        "the cursor.");
  }
}

}  // namespace qs
