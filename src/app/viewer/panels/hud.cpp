// SPDX-License-Identifier: MIT
//
// Performance: the numbers of all modes for this view, stage bars, and the frame in the window.
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/hud_text.h"

namespace qs {
namespace {

double stage_sum(const BenchRow& row) {
  double sum = 0;
  for (const double ms : stages_of(row)) sum += ms;
  return sum;
}

// A bar per stage, end to end; `longest` milliseconds fill the column.
void draw_stage_bar(const BenchRow* row, double longest) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, height = ImGui::GetTextLineHeight();
  if (row != nullptr && longest > 0) {
    float x = at.x;
    const auto stages = stages_of(*row);
    for (std::size_t stage = 0; stage < stages.size(); ++stage) {
      const float end = x + width * static_cast<float>(stages[stage] / longest);
      ImGui::GetWindowDrawList()->AddRectFilled({x, at.y + 2}, {end, at.y + height - 2},
                                                ImGui::GetColorU32(palette::kStages[stage]));
      x = end;
    }
  }
  ImGui::Dummy({width, height});
  if (row != nullptr && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", stages_text(*row).c_str());
}

void draw_stage_legend() {
  for (int stage = 0; stage < kStageCount; ++stage) {
    if (stage > 0) ImGui::SameLine(0, 14);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float side = ImGui::GetTextLineHeight() * 0.6f;
    const float top = at.y + 0.5f * (ImGui::GetTextLineHeight() - side);
    ImGui::GetWindowDrawList()->AddRectFilled({at.x, top}, {at.x + side, top + side},
                                              ImGui::GetColorU32(palette::kStages[stage]));
    ImGui::Dummy({side, side});
    ImGui::SameLine(0, 5);
    ImGui::TextColored(palette::kFaint, "%s", kStageNames[stage]);
  }
}

void draw_mode_table(const Viewer& viewer, Actions& actions) {
  double longest = 0;
  for (CullMode mode = 1; mode <= kCullerCount; ++mode) {
    const BenchRow* row = measured_row(viewer, mode, viewer.settings.pipeline);
    if (row != nullptr) longest = std::max(longest, stage_sum(*row));
  }
  const std::optional<Pipeline> other = other_pipeline(viewer);
  const std::vector<std::string> titles = hud_columns(viewer);
  const int columns = static_cast<int>(titles.size()) + (other ? 3 : 1);
  const ImGuiTableFlags flags = ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit;
  if (!ImGui::BeginTable("modes", columns, flags)) return;
  const float em = ImGui::GetFontSize();
  const float widths[] = {7.0f * em, 6.0f * em, 3.2f * em, 4.6f * em,
                          4.6f * em, 3.4f * em, 8.4f * em};
  for (std::size_t i = 0; i < titles.size(); ++i)
    ImGui::TableSetupColumn(titles[i].c_str(), ImGuiTableColumnFlags_WidthFixed, widths[i]);
  if (other) {
    const char* name = kPipelineNames[static_cast<int>(*other)];
    ImGui::TableSetupColumn(fmt::format("{} ms", name).c_str(), ImGuiTableColumnFlags_WidthFixed,
                            6.0f * em);
    ImGui::TableSetupColumn((titles.back() + " ").c_str(), ImGuiTableColumnFlags_WidthFixed,
                            8.4f * em);
  }
  ImGui::TableSetupColumn("stages", ImGuiTableColumnFlags_WidthFixed, 5.0f * em);
  ImGui::TableNextRow();
  for (int i = 0; i < columns; ++i) {
    ImGui::TableNextColumn();
    ImGui::PushStyleColor(ImGuiCol_Text, palette::kFaint);
    const bool words = i == 0 || i == columns - 1;
    if (words) ImGui::TextUnformatted(ImGui::TableGetColumnName(i));
    if (!words) right_aligned(ImGui::TableGetColumnName(i));
    ImGui::PopStyleColor();
  }
  const bool current = numbers_are_current(viewer);
  for (const HudRow& row : hud_rows(viewer)) {
    const bool chosen = row.mode == viewer.mode();
    ImGui::TableNextRow();
    if (chosen)
      ImGui::TableSetBgColor(ImGuiTableBgTarget_RowBg0, ImGui::GetColorU32(ImGuiCol_Header));
    ImGui::TableNextColumn();
    const std::string label = fmt::format("{} {}", row.mode, row.name);
    if (ImGui::Selectable(label.c_str(), false, ImGuiSelectableFlags_SpanAllColumns))
      actions.push_back(call(action::set_mode, row.mode));
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("%s\n%s\nright click: ratios to this mode", row_of(row.mode).summary,
                        trust_text(viewer, row.mode).c_str());
    }
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right))
      actions.push_back(call(action::set_baseline, row.mode));
    std::vector<std::pair<std::string, bool>> cells = {
        {row.ms, row.is_noisy},   {row.fps, row.is_noisy}, {row.pairs, false},
        {row.per_visible, false}, {row.unused, false},     {row.ratio, row.is_noisy}};
    if (other) {
      cells.emplace_back(row.other_ms, row.other_noisy);
      cells.emplace_back(row.other_ratio, row.other_noisy);
    }
    for (const auto& [text, noisy] : cells) {
      ImGui::PushStyleColor(ImGuiCol_Text, current && !noisy ? palette::kText : palette::kFaint);
      ImGui::TableNextColumn();
      right_aligned(text);
      ImGui::PopStyleColor();
    }
    ImGui::TableNextColumn();
    draw_stage_bar(measured_row(viewer, row.mode, viewer.settings.pipeline), longest);
  }
  ImGui::EndTable();
}

// Two facts to a line, so that the panel stays low.
void draw_frame_facts(const Viewer& viewer) {
  if (!ImGui::BeginTable("facts", 4, ImGuiTableFlags_SizingFixedFit)) return;
  const float em = ImGui::GetFontSize();
  for (const float width : {5.0f * em, 12.5f * em, 5.0f * em, 9.0f * em})
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, width);
  for (const Fact& fact : hud_facts(viewer)) {
    ImGui::TableNextColumn();
    ImGui::TextColored(palette::kFaint, "%s", fact.label.c_str());
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(fact.value.c_str());
  }
  ImGui::EndTable();
}

void draw_plot(const Viewer& viewer) {
  if (viewer.frame_ms.size() < 8) return;
  const std::vector<float> values(viewer.frame_ms.begin(), viewer.frame_ms.end());
  const float most = *std::max_element(values.begin(), values.end());
  ImGui::PushStyleColor(ImGuiCol_FrameBg, {0.12f, 0.125f, 0.14f, 1});
  ImGui::PlotLines("##frames", values.data(), static_cast<int>(values.size()), 0, nullptr, 0,
                   most * 1.15f, {ImGui::GetContentRegionAvail().x, 3.2f * ImGui::GetFontSize()});
  ImGui::PopStyleColor();
  ImGui::TextColored(palette::kFaint, "%s", frame_plot_text(viewer).c_str());
}

}  // namespace

void draw_hud(const Viewer& viewer, Actions& actions, float top) {
  ImGui::SetNextWindowPos({10, top + 10}, ImGuiCond_FirstUseEver);
  const ImGuiWindowFlags flags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize |
                                 ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;
  ImGui::Begin("Performance", nullptr, flags);
  draw_mode_table(viewer, actions);
  draw_stage_legend();
  ImGui::TextColored(palette::kFaint, "%s", hud_status(viewer).c_str());
  if (other_pipeline(viewer))
    ImGui::TextColored(palette::kFaint,
                       "culling saves more in classic, which spends more on pairs");
  ImGui::Separator();
  draw_frame_facts(viewer);
  const std::string caveat = hud_caveat(viewer);
  if (!caveat.empty()) ImGui::TextColored(palette::kCaution, "this frame: %s", caveat.c_str());
  draw_plot(viewer);
  ImGui::End();
}

}  // namespace qs
