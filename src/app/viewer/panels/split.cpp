// SPDX-License-Identifier: MIT
//
// The divider of a split window, and the names of its sides.
#include <algorithm>

#include <imgui.h>

#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

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

}  // namespace qs
