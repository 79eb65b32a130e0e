// SPDX-License-Identifier: MIT
//
// The numbers of all modes for this view, and the frame in the window.
#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "app/viewer/panel_model/panel_model.h"
#include "app/viewer/state/hud_text.h"

namespace qs {
namespace {

// The ends of the axes of all bars: milliseconds, and FPS above the fastest mode's interval. In
// flight, pairs have bars until all modes have FPS.
struct TableScale {
  double ms = 0, fps = 0, pairs = 0;
};

TableScale table_scale(const Viewer& v, const std::vector<HudRow>& rows) {
  TableScale scale;
  const auto has_rate = [](const HudRow& row) { return row.fps.value > 0 || !row.is_live; };
  const bool has_rates = std::ranges::all_of(rows, has_rate);
  for (const HudRow& row : rows) {
    if (!has_rates) {
      scale.pairs = std::max(scale.pairs, 1.05 * row.pairs.value);
      continue;
    }
    scale.fps = std::max({scale.fps, 1.05 * row.fps.value, 1.05 * row.fps_high});
    if (const BenchRow* measured = measured_row(v, row.mode, v.settings.pipeline)) {
      const auto stages = stages_of(*measured);
      scale.ms = std::max(scale.ms, std::accumulate(stages.begin(), stages.end(), 0.0));
    }
  }
  return scale;
}

block::Cell table_cell(const Viewer& v, const HudRow& row, const TableColumn& column,
                       const TableScale& scale) {
  const HudCell number = column.cell == nullptr ? HudCell{""} : row.*column.cell;
  block::Cell cell{number.text, number.noisy ? Tone::faint : Tone::plain, number.value};
  const BenchRow* measured = measured_row(v, row.mode, v.settings.pipeline);
  if (column.kind == CellKind::mode) {
    if (!v.is_remote) cell.text = fmt::format("{} {}", row.mode, number.text);
    cell.use = Use{"mode", 0, static_cast<std::size_t>(row.mode)};
    cell.tooltip = fmt::format("{}\n{}", row_of(row.mode).summary, trust_text(v, row.mode));
    if (!v.is_remote) cell.tooltip += "\nright click: copy the table, or ratios to this mode";
  } else if (column.kind == CellKind::bar && scale.fps > 0) {
    cell.bar = block::Bar{row.fps.value / scale.fps, row.fps_low / scale.fps,
                          row.fps_high / scale.fps, ink_of(row.mode)};
  } else if (column.cell == &HudRow::pairs && scale.pairs > 0) {
    cell.bar = block::Bar{row.pairs.value / scale.pairs, 0, 0, ink_of(row.mode)};
  } else if (column.kind == CellKind::stages && !row.is_live && measured != nullptr &&
             scale.ms > 0) {
    for (const double ms : stages_of(*measured)) cell.parts.push_back(ms / scale.ms);
    cell.tooltip = stages_text(*measured);
  }
  return cell;
}

std::vector<std::string> table_buttons() {
  std::vector<std::string> names;
  for (const char* format : kTableFormats) names.push_back(fmt::format("The table as {}", format));
  return names;
}

std::vector<Use> row_menu(const HudRow& row) {
  std::vector<Use> menu = {
      {"ratios to", row.name.value - 1, 0, fmt::format("Ratios to {}", row.name.text)}};
  for (const std::string& name : table_buttons())
    menu.push_back({name, 0, 0, fmt::format("Copy t{}", name.substr(1))});
  return menu;
}

block::Table mode_table(const Viewer& v) {
  const std::vector<HudRow> rows = hud_rows(v);
  const TableScale scale = table_scale(v, rows);
  block::Table table{.name = "modes", .caption = table_caption(v), .is_busy = v.measuring};
  const std::vector<TableColumn> columns = table_columns(v);
  for (const TableColumn& column : columns) {
    const bool is_rate = column.kind == CellKind::bar;
    const bool is_bar = scale.pairs > 0 ? column.cell == &HudRow::pairs : is_rate;
    table.columns.push_back({column.title, column.letters, is_bar ? 1.0f : 0.0f, column.rank,
                             column.kind == CellKind::mode, column.cell != nullptr, is_rate});
  }
  for (const HudRow& row : rows) {
    block::Row& line = table.rows.emplace_back();
    line.is_here = row.mode == v.mode();
    line.menu = row_menu(row);
    for (const TableColumn& column : columns)
      line.cells.push_back(table_cell(v, row, column, scale));
  }
  for (std::size_t stage = 0; stage < kStageCount; ++stage)
    table.keys.push_back({kStageNames[stage], {on_dark::kStages[stage], on_white::kStages[stage]}});
  return table;
}

}  // namespace

Blocks table_blocks(const Viewer& v) {
  Blocks blocks = {mode_table(v)};
  block::Controls controls = {{{"measure at", block::kWholeLine, false, {}, "measure at"}}};
  if (v.is_remote) {
    controls.controls.push_back({"ratios to"});
    for (const std::string& name : table_buttons()) controls.controls.push_back({name});
  }
  blocks.emplace_back(controls);
  blocks.push_back(block::Text{hud_status(v), Tone::faint});
  if (other_pipeline(v))
    blocks.push_back(
        block::Text{"culling saves more in classic, which spends more on pairs", Tone::faint});
  blocks.push_back(block::Line{});
  blocks.push_back(block::Facts{hud_facts(v)});
  const std::string caveat = hud_caveat(v);
  blocks.push_back(block::Text{caveat.empty() ? "" : "this frame: " + caveat, Tone::caution});
  if (!v.is_remote && v.frame_ms.size() >= 8)
    blocks.push_back(block::Plot{{v.frame_ms.begin(), v.frame_ms.end()}, frame_plot_text(v)});
  return blocks;
}

}  // namespace qs
