// SPDX-License-Identifier: MIT
//
// Performance: the numbers of all modes for this view, stage bars, and the frame in the window.
#include <algorithm>
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

// A column of the table. If the bar is too narrow for all columns, the columns with the highest
// rank are left out.
struct Column {
  std::string title;
  float letters;  // width
  int rank;
  std::string HudRow::*text = nullptr;  // null: the name or the stages
  bool HudRow::*noisy = nullptr;
};

std::vector<Column> columns_that_fit(const Viewer& viewer) {
  const std::vector<std::string> titles = hud_columns(viewer);
  std::vector<Column> columns = {
      {titles[0], 6.6f, 0},
      {titles[1], 5.2f, 1, &HudRow::ms, &HudRow::is_noisy},
      {titles[2], 2.8f, 5, &HudRow::fps, &HudRow::is_noisy},
      {titles[3], 4.2f, 3, &HudRow::pairs},
      {titles[4], 4.6f, 9, &HudRow::per_visible},
      {titles[5], 3.4f, 6, &HudRow::unused},
      {titles[6], 7.0f, 2, &HudRow::ratio, &HudRow::is_noisy},
  };
  if (const auto other = other_pipeline(viewer)) {
    const char* name = kPipelineNames[static_cast<int>(*other)];
    columns.push_back(
        {fmt::format("{} ms", name), 5.2f, 7, &HudRow::other_ms, &HudRow::other_noisy});
    columns.push_back({titles[6] + " ", 7.0f, 8, &HudRow::other_ratio, &HudRow::other_noisy});
  }
  columns.push_back({"stages", 5.0f, 4});
  const float padding = 2 * ImGui::GetStyle().CellPadding.x;
  const auto width = [&] {
    float sum = 0;
    for (const Column& column : columns) sum += column.letters * ImGui::GetFontSize() + padding;
    return sum;
  };
  const auto by_rank = [](const Column& a, const Column& b) { return a.rank < b.rank; };
  while (columns.size() > 1 && width() > ImGui::GetContentRegionAvail().x)
    columns.erase(std::max_element(columns.begin(), columns.end(), by_rank));
  return columns;
}

void draw_mode_name(const Viewer& viewer, const HudRow& row, Actions& actions) {
  const std::string label = fmt::format("{} {}", row.mode, row.name);
  if (ImGui::Selectable(label.c_str(), false, ImGuiSelectableFlags_SpanAllColumns))
    actions.push_back(call(action::set_mode, row.mode));
  if (ImGui::IsItemHovered()) {
    ImGui::SetTooltip("%s\n%s\nright click: ratios to this mode", row_of(row.mode).summary,
                      trust_text(viewer, row.mode).c_str());
  }
  if (ImGui::IsItemClicked(ImGuiMouseButton_Right))
    actions.push_back(call(action::set_baseline, row.mode));
}

// Returns true if the stages were drawn.
bool draw_mode_table(const Viewer& viewer, Actions& actions) {
  double longest = 0;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const BenchRow* row = measured_row(viewer, mode, viewer.settings.pipeline);
    if (row != nullptr) longest = std::max(longest, stage_sum(*row));
  }
  const std::vector<Column> columns = columns_that_fit(viewer);
  const ImGuiTableFlags flags = ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit;
  if (!ImGui::BeginTable("modes", static_cast<int>(columns.size()), flags)) return false;
  for (const Column& column : columns)
    ImGui::TableSetupColumn(column.title.c_str(), ImGuiTableColumnFlags_WidthFixed,
                            column.letters * ImGui::GetFontSize());
  ImGui::TableNextRow();
  ImGui::PushStyleColor(ImGuiCol_Text, palette::kFaint);
  for (const Column& column : columns) {
    ImGui::TableNextColumn();
    if (column.text == nullptr) ImGui::TextUnformatted(column.title.c_str());
    if (column.text != nullptr) right_aligned(column.title);
  }
  ImGui::PopStyleColor();
  const bool current = numbers_are_current(viewer);
  for (const HudRow& row : hud_rows(viewer)) {
    ImGui::TableNextRow();
    if (row.mode == viewer.mode())
      ImGui::TableSetBgColor(ImGuiTableBgTarget_RowBg0, ImGui::GetColorU32(ImGuiCol_Header));
    for (const Column& column : columns) {
      ImGui::TableNextColumn();
      if (column.text != nullptr) {
        const bool noisy = column.noisy != nullptr && row.*column.noisy;
        ImGui::PushStyleColor(ImGuiCol_Text, current && !noisy ? palette::kText : palette::kFaint);
        right_aligned(row.*column.text);
        ImGui::PopStyleColor();
      } else if (column.rank == 0) {
        draw_mode_name(viewer, row, actions);
      } else {
        draw_stage_bar(measured_row(viewer, row.mode, viewer.settings.pipeline), longest);
      }
    }
  }
  ImGui::EndTable();
  return columns.back().text == nullptr && columns.size() > 1;
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

void draw_hud(const Viewer& viewer, PanelState&, Actions& actions) {
  if (draw_mode_table(viewer, actions)) draw_stage_legend();
  ImGui::PushStyleColor(ImGuiCol_Text, palette::kFaint);
  ImGui::TextWrapped("%s", hud_status(viewer).c_str());
  if (other_pipeline(viewer))
    ImGui::TextWrapped("culling saves more in classic, which spends more on pairs");
  ImGui::PopStyleColor();
  ImGui::Separator();
  for (const Fact& fact : hud_facts(viewer)) draw_fact(fact);
  const std::string caveat = hud_caveat(viewer);
  if (!caveat.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, palette::kCaution);
    ImGui::TextWrapped("this frame: %s", caveat.c_str());
    ImGui::PopStyleColor();
  }
  draw_plot(viewer);
}

void draw_status_line(const Viewer& viewer, const Rect& area) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  draw.AddRectFilled({area.low.x, area.low.y}, {area.high.x, area.high.y},
                     ImGui::GetColorU32(ImGuiCol_MenuBarBg));
  if (!viewer.scene && !viewer.loading) return;
  const float letter = ImGui::GetFontSize();
  const float y = area.center().y - 0.5f * letter;
  const StatusLine line = status_line(viewer);
  const float note = area.high.x - ImGui::CalcTextSize(line.note.c_str()).x - 0.8f * letter;
  draw.PushClipRect({area.low.x, area.low.y}, {note - letter, area.high.y}, true);
  draw.AddText({area.low.x + 0.8f * letter, y}, ImGui::GetColorU32(palette::kText),
               line.numbers.c_str());
  draw.PopClipRect();
  draw.AddText({note, y}, ImGui::GetColorU32(line.caution ? palette::kCaution : palette::kFaint),
               line.note.c_str());
}

}  // namespace qs
