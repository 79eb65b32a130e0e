// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/mode_table.h"

namespace qs {
namespace {

// A column that fits into the panel.
struct ShownColumn : block::Column {
  std::size_t cell = 0;      ///< index into Row::cells
  float beside_bars = 0.0f;  ///< width that bars leave to the numbers, which are not on them
};

std::vector<ShownColumn> shown_columns(const block::Table& table) {
  std::vector<ShownColumn> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) columns.push_back({table.columns[i], i});
  const float letter = ImGui::GetFontSize();
  return columns_that_fit(std::move(columns), ImGui::GetContentRegionAvail().x / letter,
                          2 * ImGui::GetStyle().CellPadding.x / letter);
}

void set_up_columns(const std::vector<ShownColumn>& columns) {
  for (const ShownColumn& column : columns) {
    ImGuiTableColumnFlags flags =
        column.share > 0 ? ImGuiTableColumnFlags_WidthStretch : ImGuiTableColumnFlags_WidthFixed;
    if (!column.is_ordering) flags |= ImGuiTableColumnFlags_NoSort;
    if (column.is_ordering && column.is_left) flags |= ImGuiTableColumnFlags_DefaultSort;
    if (column.descends) flags |= ImGuiTableColumnFlags_PreferSortDescending;
    ImGui::TableSetupColumn(
        column.title.c_str(), flags,
        column.share > 0 ? column.share : column.letters * ImGui::GetFontSize());
  }
}

// Titles stand as the numbers below them, left of the arrow of the order. ImGui's own are at the
// left.
void draw_head(const std::vector<ShownColumn>& columns, bool is_ordering) {
  ImGui::TableNextRow(ImGuiTableRowFlags_Headers);
  const ImGuiTableSortSpecs* order = is_ordering ? ImGui::TableGetSortSpecs() : nullptr;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    ImGui::TableNextColumn();
    const std::string& title = columns[i].title;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x;
    const bool has_arrow = order != nullptr && order->SpecsCount > 0 &&
                           order->Specs->ColumnIndex == static_cast<int>(i);
    const float arrow = has_arrow ? 0.65f * ImGui::GetFontSize() : 0;
    const float free = std::max(0.0f, width - arrow - ImGui::CalcTextSize(title.c_str()).x);
    if (is_ordering) ImGui::TableHeader(("##" + title).c_str());
    ImGui::GetWindowDrawList()->AddText({at.x + (columns[i].is_left ? 0 : free), at.y},
                                        ImGui::GetColorU32(palette::kFaint), title.c_str());
  }
}

// Orders the rows as the headers say.
void sort_as_chosen(std::vector<block::Row>& rows, const std::vector<ShownColumn>& columns) {
  const ImGuiTableSortSpecs* specs = ImGui::TableGetSortSpecs();
  if (specs == nullptr || specs->SpecsCount == 0) return;
  const ShownColumn& column = columns[static_cast<std::size_t>(specs->Specs->ColumnIndex)];
  if (!column.is_ordering) return;
  sort_rows(
      rows, [&](const block::Row& row) { return row.cells[column.cell].value; },
      specs->Specs->SortDirection == ImGuiSortDirection_Descending);
}

// The whole place of a cell without its padding.
struct CellPlace {
  ImVec2 at = ImGui::GetCursorScreenPos();
  float width = ImGui::GetContentRegionAvail().x, height = ImGui::GetTextLineHeight();

  float x(double share) const { return at.x + width * static_cast<float>(share); }
  void fill(float from, float to, float inset, ImU32 color, float rounding = 0) const {
    ImGui::GetWindowDrawList()->AddRectFilled({from, at.y + inset}, {to, at.y + height - inset},
                                              color, rounding);
  }
};

void draw_cell_bar(const block::Bar& bar, float beside) {
  CellPlace place;
  place.width = std::max(0.0f, place.width - beside);
  const ImU32 color = color_of(bar.ink);
  if (bar.value > 0) {
    place.fill(place.at.x, place.x(bar.value), 1, color_of(bar.ink, 0.45f));
    place.fill(place.at.x, place.at.x + 0.2f * ImGui::GetFontSize(), 1, color);
  }
  if (bar.low <= 0) return;
  const float y = place.at.y + place.height - 2;
  ImGui::GetWindowDrawList()->AddLine({place.x(bar.low), y}, {place.x(bar.high), y}, color, 2);
}

void draw_parts(const std::vector<double>& parts, const std::vector<block::Key>& keys) {
  const CellPlace place;
  double begin = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double end = begin + parts[i];
    place.fill(place.x(begin), place.x(end), 2, color_of(keys[i].ink));
    begin = end;
  }
  ImGui::Dummy({place.width, place.height});
}

void draw_swatch(glm::vec3 color) {
  const CellPlace place;
  const float width = 2 * place.height;
  place.fill(place.at.x, place.at.x + width, 0, color_of(color), 3);
  ImGui::Dummy({width, place.height});
}

void draw_row_menu(const block::Row& row, const ControlsDrawer& controls) {
  if (row.menu.empty() || !ImGui::BeginPopupContextItem()) return;
  for (const Use& use : row.menu)
    if (ImGui::MenuItem(use.label.c_str())) controls.set(use);
  ImGui::EndPopup();
}

void draw_cell(const block::Table& table, const block::Row& row, const ShownColumn& column,
               const ControlsDrawer& controls) {
  const block::Cell& cell = row.cells[column.cell];
  const char* const text = cell.text.c_str();
  const bool has_buttons = std::ranges::any_of(row.cells, &block::Cell::is_button);
  ImGui::PushStyleColor(ImGuiCol_Text, cell.tone == Tone::faint ? palette::kFaint : palette::kText);
  if (cell.is_button) {
    if (ImGui::SmallButton(text)) controls.set(*cell.use);
  } else if (cell.use) {
    const auto span = has_buttons ? 0 : ImGuiSelectableFlags_SpanAllColumns;
    if (ImGui::Selectable(text, has_buttons && row.is_here, span)) controls.set(*cell.use);
  } else if (!cell.parts.empty()) {
    draw_parts(cell.parts, table.keys);
  } else if (cell.swatch) {
    draw_swatch(*cell.swatch);
  } else {
    if (cell.bar) draw_cell_bar(*cell.bar, column.beside_bars);
    if (column.is_left)
      ImGui::TextUnformatted(cell.text.c_str());
    else
      right_aligned(cell.text);
  }
  ImGui::PopStyleColor();
  if (!cell.tooltip.empty() && ImGui::IsItemHovered()) tooltip_beside(cell.tooltip);
  if (cell.use && !cell.is_button) draw_row_menu(row, controls);
}

void draw_rows(const block::Table& table, const std::vector<block::Row>& rows,
               const std::vector<ShownColumn>& columns, bool scrolls,
               const ControlsDrawer& controls) {
  for (const block::Row& row : rows) {
    ImGui::TableNextRow();
    if (row.is_here && !table.columns.empty())
      ImGui::TableSetBgColor(ImGuiTableBgTarget_RowBg0, ImGui::GetColorU32(ImGuiCol_Header));
    const std::optional<Use>& use = row.cells[0].use;
    ImGui::PushID(use ? fmt::format("{} {}", use->index, row.cells[0].text).c_str()
                      : row.cells[0].text.c_str());
    for (const ShownColumn& column : columns) {
      ImGui::TableNextColumn();
      draw_cell(table, row, column, controls);
    }
    if (row.is_here && scrolls) ImGui::SetScrollHereY();
    ImGui::PopID();
  }
}

// Squares in the colours of the parts of a bar.
void draw_part_keys(const std::vector<block::Key>& keys) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i > 0) ImGui::SameLine(0, 14);
    const CellPlace place;
    const float side = 0.6f * place.height;
    place.fill(place.at.x, place.at.x + side, 0.2f * place.height, color_of(keys[i].ink));
    ImGui::Dummy({side, side});
    ImGui::SameLine(0, 5);
    ImGui::TextColored(palette::kFaint, "%s", keys[i].text.c_str());
  }
}

}  // namespace

void draw_table(const block::Table& table, PanelState& state, const ControlsDrawer& controls) {
  std::vector<ShownColumn> columns = shown_columns(table);
  for (ShownColumn& column : columns) {
    for (const block::Row& row : table.rows) {
      const block::Cell& cell = row.cells[column.cell];
      const float text = ImGui::CalcTextSize(cell.text.c_str()).x + 0.4f * ImGui::GetFontSize();
      if (cell.bar) column.beside_bars = std::max(column.beside_bars, text);
    }
  }
  if (table.name == std::string_view("modes")) state.columns = titles_of(columns);
  const bool is_ordering = std::ranges::any_of(columns, &ShownColumn::is_ordering);
  ImGuiTableFlags flags = ImGuiTableFlags_RowBg | ImGuiTableFlags_NoSavedSettings;
  if (is_ordering) flags |= ImGuiTableFlags_Sortable;
  const float line = ImGui::GetTextLineHeight() + 2 * ImGui::GetStyle().CellPadding.y;
  const int lines = std::min(static_cast<int>(table.rows.size()) + 2, table.most_lines);
  if (lines > 0) flags |= ImGuiTableFlags_ScrollY;
  // A table of its own for each set of columns and the wide ones of them, because ImGui keeps the
  // order and the widths of a table's columns.
  std::string id = table.name;
  for (const ShownColumn& column : columns)
    id += " " + column.title + (column.share > 0 ? "*" : "");
  if (!ImGui::BeginTable(id.c_str(), static_cast<int>(columns.size()), flags,
                         {0, static_cast<float>(lines) * line}))
    return;
  set_up_columns(columns);
  if (lines > 0) ImGui::TableSetupScrollFreeze(0, 1);
  if (table.has_head) draw_head(columns, is_ordering);
  std::vector<block::Row> rows = table.rows;
  sort_as_chosen(rows, columns);
  const bool scrolls = std::exchange(state.scrolled[table.name], table.version) != table.version;
  draw_rows(table, rows, columns, scrolls, controls);
  ImGui::EndTable();
  if (!table.keys.empty() && columns.back().cell + 1 == table.columns.size())
    draw_part_keys(table.keys);
}

}  // namespace qs
