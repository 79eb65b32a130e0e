// SPDX-License-Identifier: MIT
//
// Performance: the numbers of all modes for this view, stage bars, and the frame in the window.
#include <algorithm>
#include <iterator>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/controls_drawer.h"
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

// FPS as a bar in the mode's colour; `most` FPS fill the cell. A line spans the middle half of the
// frames.
void draw_rate_bar(const HudRow& row, double most) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, height = ImGui::GetTextLineHeight();
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const glm::vec3 color = on_dark::mode_color(row.mode);
  const auto place = [&](double fps) { return at.x + width * static_cast<float>(fps / most); };
  if (row.fps_value > 0 && most > 0) {
    draw.AddRectFilled({at.x, at.y + 1}, {place(row.fps_value), at.y + height - 1},
                       color_of(color, 0.45f));
    draw.AddRectFilled({at.x, at.y + 1}, {at.x + 0.2f * ImGui::GetFontSize(), at.y + height - 1},
                       color_of(color));
  }
  if (row.fps_low > 0) {
    const float y = at.y + height - 2;
    draw.AddLine({place(row.fps_low), y}, {place(row.fps_high), y}, color_of(color), 2);
  }
  right_aligned(row.fps);
}

// The end of the bars' axis: above the fastest mode's interval.
double most_fps(const std::vector<HudRow>& rows) {
  double most = 0;
  for (const HudRow& row : rows) most = std::max({most, row.fps_value, row.fps_high});
  return 1.05 * most;
}

void draw_row_menu(const Viewer& viewer, const HudRow& row, Actions& actions) {
  if (!ImGui::BeginPopupContextItem()) return;
  if (ImGui::MenuItem(fmt::format("Ratios to {}", row.name).c_str()))
    ControlsDrawer(viewer, actions).set("ratios to", row.mode - 1);
  ImGui::Separator();
  for (std::size_t i = 0; i < std::size(kTableFormats); ++i) {
    if (ImGui::MenuItem(fmt::format("Copy the table as {}", kTableFormats[i]).c_str()))
      actions.push_back(call(action::copy_table, static_cast<TableFormat>(i)));
  }
  ImGui::EndPopup();
}

void draw_mode_name(const Viewer& viewer, const HudRow& row, Actions& actions) {
  const std::string label = fmt::format("{} {}", row.mode, row.name);
  if (ImGui::Selectable(label.c_str(), false, ImGuiSelectableFlags_SpanAllColumns))
    actions.push_back(call(action::set_mode, row.mode));
  if (ImGui::IsItemHovered()) {
    ImGui::SetTooltip("%s\n%s\nright click: copy the table, or ratios to this mode",
                      row_of(row.mode).summary, trust_text(viewer, row.mode).c_str());
  }
  draw_row_menu(viewer, row, actions);
}

// The common facts of all cells of the table.
struct TableScale {
  double longest_ms = 0;  ///< stages that fill their column
  double most_fps = 0;
  bool current = false;  ///< the numbers are of this view
};

void draw_cell(const Viewer& viewer, const HudRow& row, const TableColumn& column,
               const TableScale& scale, Actions& actions) {
  const bool noisy = column.noisy != nullptr && row.*column.noisy;
  const bool live = column.value == &HudRow::pairs_value && row.pairs_live;
  const bool sampled = column.kind == CellKind::bar && row.fps_sampled;  // "~" marks it
  const bool trusted = live || sampled || (scale.current && !noisy);
  ImGui::PushStyleColor(ImGuiCol_Text, trusted ? palette::kText : palette::kFaint);
  switch (column.kind) {
    case CellKind::mode:
      draw_mode_name(viewer, row, actions);
      break;
    case CellKind::bar:
      draw_rate_bar(row, scale.most_fps);
      break;
    case CellKind::number:
      right_aligned(row.*column.text);
      break;
    case CellKind::stages:
      draw_stage_bar(measured_row(viewer, row.mode, viewer.settings.pipeline), scale.longest_ms);
      break;
  }
  ImGui::PopStyleColor();
}

void set_up_columns(const std::vector<TableColumn>& columns) {
  for (const TableColumn& column : columns) {
    ImGuiTableColumnFlags flags = column.kind == CellKind::bar ? ImGuiTableColumnFlags_WidthStretch
                                                               : ImGuiTableColumnFlags_WidthFixed;
    if (column.value == nullptr) flags |= ImGuiTableColumnFlags_NoSort;
    if (column.kind == CellKind::mode) flags |= ImGuiTableColumnFlags_DefaultSort;
    if (column.kind == CellKind::bar) flags |= ImGuiTableColumnFlags_PreferSortDescending;
    ImGui::TableSetupColumn(
        column.title.c_str(), flags,
        column.kind == CellKind::bar ? 1 : column.letters * ImGui::GetFontSize());
  }
}

// Orders the rows as the headers say.
void sort_as_chosen(std::vector<HudRow>& rows, const std::vector<TableColumn>& columns) {
  const ImGuiTableSortSpecs* specs = ImGui::TableGetSortSpecs();
  if (specs == nullptr || specs->SpecsCount == 0) return;
  const TableColumn& column = columns[static_cast<std::size_t>(specs->Specs->ColumnIndex)];
  if (column.value != nullptr)
    sort_rows(rows, column.value, specs->Specs->SortDirection == ImGuiSortDirection_Descending);
}

// Returns true if the stages were drawn.
bool draw_mode_table(const Viewer& viewer, PanelState& state, Actions& actions) {
  std::vector<HudRow> rows = hud_rows(viewer);
  TableScale scale{0, most_fps(rows), numbers_are_current(viewer)};
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const BenchRow* row = measured_row(viewer, mode, viewer.settings.pipeline);
    if (row != nullptr) scale.longest_ms = std::max(scale.longest_ms, stage_sum(*row));
  }
  const float letter = ImGui::GetFontSize();
  const std::vector<TableColumn> columns =
      columns_that_fit(table_columns(viewer), ImGui::GetContentRegionAvail().x / letter,
                       2 * ImGui::GetStyle().CellPadding.x / letter);
  state.columns = titles_of(columns);
  // A table of its own for each set of columns, because ImGui keeps the order of a table's columns.
  const std::string id = fmt::format("modes {}", fmt::join(state.columns, " "));
  const ImGuiTableFlags flags =
      ImGuiTableFlags_RowBg | ImGuiTableFlags_Sortable | ImGuiTableFlags_NoSavedSettings;
  if (!ImGui::BeginTable(id.c_str(), static_cast<int>(columns.size()), flags)) return false;
  set_up_columns(columns);
  ImGui::PushStyleColor(ImGuiCol_Text, palette::kFaint);
  ImGui::TableHeadersRow();
  ImGui::PopStyleColor();
  sort_as_chosen(rows, columns);
  for (const HudRow& row : rows) {
    ImGui::TableNextRow();
    if (row.mode == viewer.mode())
      ImGui::TableSetBgColor(ImGuiTableBgTarget_RowBg0, ImGui::GetColorU32(ImGuiCol_Header));
    for (const TableColumn& column : columns) {
      ImGui::TableNextColumn();
      draw_cell(viewer, row, column, scale, actions);
    }
  }
  ImGui::EndTable();
  return columns.back().kind == CellKind::stages;
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

void draw_hud(const Viewer& viewer, PanelState& state, Actions& actions) {
  if (draw_mode_table(viewer, state, actions)) draw_stage_legend();
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(palette::kFaint, "measure at");
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-1);
  ControlsDrawer(viewer, actions).draw("measure at", "");
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
  draw.AddText({area.low.x + 0.8f * letter, y},
               ImGui::GetColorU32(line.faint ? palette::kFaint : palette::kText),
               line.numbers.c_str());
  draw.PopClipRect();
  draw.AddText({note, y}, ImGui::GetColorU32(line.caution ? palette::kCaution : palette::kFaint),
               line.note.c_str());
}

}  // namespace qs
