// SPDX-License-Identifier: MIT
//
// The split window: the divider between the view and another variant of it or another scene, and
// the panel that chooses the other side and shows the differences.
#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/color_bar.h"
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

// Chooses the other variant: a mode or the reference, drawn by any backend and pipeline.
void choose_other(const Viewer& viewer, Actions& actions) {
  Variant other = viewer.split.other;
  const float em = ImGui::GetFontSize();
  ImGui::SetNextItemWidth(10 * em);
  if (ImGui::BeginCombo("##mode", mode_name(other.mode))) {
    for (CullMode mode = 0; mode <= mode_count(); ++mode) {
      if (ImGui::Selectable(mode_name(mode), mode == other.mode)) other.mode = mode;
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", row_of(mode).summary);
    }
    ImGui::EndCombo();
  }
  const auto backends = available_backends();
  if (other.mode != kReferenceMode && backends.size() > 1) {
    same_line_if_fits(9 * em);
    ImGui::SetNextItemWidth(9 * em);
    const std::string drawn = drawn_by(other);
    if (ImGui::BeginCombo("##drawn", drawn.c_str())) {
      for (const Backend backend : backends) {
        for (const Pipeline pipeline : pipelines_of(backend)) {
          const Variant choice{other.mode, pipeline, backend};
          if (ImGui::Selectable(drawn_by(choice).c_str(), drawn_by(choice) == drawn))
            other = choice;
        }
      }
      ImGui::EndCombo();
    }
  }
  if (other == viewer.split.other) return;
  Split split = viewer.split;
  split.other = other;
  actions.push_back(call(action::change_split, split));
}

// Closes the second scene, or chooses another variant.
void choose_what_is_beside(const Viewer& viewer, Actions& actions) {
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
  same_line_if_fits(10 * ImGui::GetFontSize());
  choose_other(viewer, actions);
}

// Powers of two, or a factor that is chosen from the frames.
void choose_amplification(const Viewer& viewer, Actions& actions) {
  Split split = viewer.split;
  const auto label = [&](int factor) {
    return factor > 0 ? fmt::format("differences times {}", factor)
                      : fmt::format("differences times {}, automatic", shown_amplification(viewer));
  };
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::BeginCombo("##amplification", label(split.amplification).c_str())) return;
  for (const int factor : {0, 1, 2, 4, 8, 16, 32, 64, 128}) {
    const std::string text = factor == 0 ? "automatic" : label(factor);
    if (!ImGui::Selectable(text.c_str(), factor == split.amplification)) continue;
    split.amplification = factor;
    actions.push_back(call(action::change_split, split));
  }
  ImGui::EndCombo();
}

void choose_view(const Viewer& viewer, Actions& actions) {
  Split split = viewer.split;
  for (std::size_t i = 0; i < std::size(kSplitViews); ++i) {
    const float letter = ImGui::GetFontSize();
    if (i > 0) same_line_if_fits(ImGui::CalcTextSize(kSplitViews[i]).x + 2 * letter);
    if (ImGui::RadioButton(kSplitViews[i], static_cast<std::size_t>(split.view) == i)) {
      split.view = static_cast<SplitView>(i);
      actions.push_back(call(action::change_split, split));
    }
    command_tooltip("Next view of the split");
  }
  if (split.view == SplitView::difference) {
    choose_amplification(viewer, actions);
  } else if (split.view != SplitView::tile_pairs) {
    if (ImGui::Button("Flip")) actions.push_back(call(action::flip_split));
    command_tooltip("Flip the split");
  }
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
    Split split = viewer.split;
    split.divider = std::clamp((*mouse - picture.low.x) / picture.size().x, 0.0f, 1.0f);
    if (split.divider != viewer.split.divider) actions.push_back(call(action::change_split, split));
  }
}

void draw_split(const Viewer& viewer, PanelState&, Actions& actions) {
  choose_what_is_beside(viewer, actions);
  choose_view(viewer, actions);
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
