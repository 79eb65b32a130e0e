// SPDX-License-Identifier: MIT
#include "app/viewer/state/mode_table.h"

#include <fmt/format.h>

#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/live_counts.h"
#include "app/viewer/state/samples.h"
#include "base/text.h"

namespace qs {

std::optional<Pipeline> other_pipeline(const Viewer& viewer) {
  if (pipelines_of(viewer.backend).size() < 2) return std::nullopt;
  return viewer.settings.pipeline == Pipeline::fast ? Pipeline::classic : Pipeline::fast;
}

namespace {

std::string time_cell(const BenchRow* row) {
  return row == nullptr ? "-" : time_text(row->ms_median, spread_ms(*row));
}

std::string rate_cell(const BenchRow* row) {
  return row == nullptr ? "-" : rate_text(row->ms_median, spread_ms(*row));
}

bool is_noisy_row(const BenchRow* row) { return row != nullptr && has_noisy_time(*row); }

// A ratio of interleaved frames can be certain although the times of a busy machine vary.
bool is_undecided_ratio(const std::optional<Ratio>& ratio) { return ratio && is_undecided(*ratio); }

std::string ratio_cell(const std::optional<Ratio>& ratio) {
  return ratio ? ratio_text(*ratio) : "-";
}

// The numbers by which the table is sorted and bars are drawn.
void set_numbers(HudRow& row, const BenchRow* measured) {
  if (measured == nullptr) return;
  row.fps_value = measured->fps_median;
  row.ms_value = measured->ms_median;
  row.pairs_value = static_cast<double>(measured->pairs);
  row.per_visible_value = measured->pairs_per_visible;
  row.unused_value = measured->false_positive_share.value_or(0);
  const std::optional<double> spread = spread_ms(*measured);
  if (!spread || *spread >= measured->ms_median) return;
  row.fps_low = 1000 / (measured->ms_median + *spread);
  row.fps_high = 1000 / (measured->ms_median - *spread);
}

// Counts of this view, or of a recent view of a moving camera, in place of an earlier measurement.
void set_live_pairs(const Viewer& viewer, HudRow& row) {
  if (numbers_are_current(viewer)) return;
  const std::optional<LiveCount> live = live_pairs(viewer, row.mode);
  if (!live) return;
  row.pairs = (live->frames_ago > 0 ? "~" : "") + grouped(live->tile_pairs);
  row.pairs_value = static_cast<double>(live->tile_pairs);
  row.pairs_live = true;
}

// The FPS of a single frame in place of an earlier measurement. Measured FPS of another view have
// no bar beside bars of samples.
void set_sample(const Viewer& viewer, HudRow& row) {
  if (numbers_are_current(viewer) || viewer.samples.empty()) return;
  row.fps_value = row.fps_low = row.fps_high = 0;
  const ModeSample* sample = sample_of(viewer, row.mode);
  if (sample == nullptr) return;
  row.fps = sample_text(*sample);
  row.fps_value = fps_of(*sample);
  row.fps_sampled = true;
}

}  // namespace

std::string unused_text(const BenchRow* row) {
  if (row == nullptr || !row->false_positives) return "-";
  return fmt::format("{:.1f} %", 100 * row->false_positive_share.value_or(0));
}

std::vector<HudRow> hud_rows(const Viewer& viewer) {
  const Pipeline here = viewer.settings.pipeline;
  const std::optional<Pipeline> other = other_pipeline(viewer);
  std::vector<HudRow> rows;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const BenchRow* found = measured_row(viewer, mode, here);
    HudRow& row = rows.emplace_back();
    row.mode = mode;
    row.mode_value = mode;
    row.name = mode_name(mode);
    set_numbers(row, found);
    row.ms = time_cell(found);
    row.fps = rate_cell(found);
    row.pairs = found == nullptr ? "-" : grouped(found->pairs);
    set_live_pairs(viewer, row);
    set_sample(viewer, row);
    row.per_visible = found == nullptr ? "-" : fmt::format("{:.2f}", found->pairs_per_visible);
    row.unused = unused_text(found);
    const std::optional<Ratio> ratio = ratio_to_baseline(viewer, found, here);
    row.is_noisy = is_noisy_row(found);
    row.ratio_noisy = is_undecided_ratio(ratio);
    row.ratio = ratio_cell(ratio);
    row.ratio_value = ratio ? ratio->value : 0;
    if (!other) continue;
    const BenchRow* beside = measured_row(viewer, mode, *other);
    const std::optional<Ratio> other_ratio = ratio_to_baseline(viewer, beside, *other);
    row.other_ms = time_cell(beside);
    row.other_noisy = is_noisy_row(beside);
    row.other_ratio_noisy = is_undecided_ratio(other_ratio);
    row.other_ratio = ratio_cell(other_ratio);
    row.other_ms_value = beside == nullptr ? 0 : beside->ms_median;
    row.other_ratio_value = other_ratio ? other_ratio->value : 0;
  }
  return rows;
}

std::string trust_text(const Viewer& viewer, CullMode mode) {
  const Pipeline here = viewer.settings.pipeline;
  const BenchRow* row = measured_row(viewer, mode, here);
  if (row == nullptr) return "not measured yet";
  const std::size_t frames = rounds_of(*row).size();
  std::string text = fmt::format("median of {} frame{}", frames, frames == 1 ? "" : "s");
  if (const std::optional<double> spread = spread_ms(*row)) {
    text +=
        fmt::format("; the middle half of them spans {} ms", significant(2 * *spread, 2 * *spread));
  }
  const std::optional<Ratio> ratio = ratio_to_baseline(viewer, row, here);
  if (ratio && ratio->interval) {
    const double half = half_interval(*ratio);
    text += fmt::format("\n95 % interval of the ratio to {}: {} to {}", mode_name(viewer.baseline),
                        significant(ratio->interval->low, half),
                        significant(ratio->interval->high, half));
    if (is_undecided(*ratio)) text += ", so these frames do not show which is faster";
  }
  return text;
}

std::vector<TableColumn> table_columns(const Viewer& viewer) {
  const std::string ratio = fmt::format("vs {}", mode_name(viewer.baseline));
  std::vector<TableColumn> columns = {
      {"mode", CellKind::mode, 6.6f, 0, nullptr, &HudRow::mode_value},
      {"FPS", CellKind::bar, 5.4f, 1, &HudRow::fps, &HudRow::fps_value, &HudRow::is_noisy},
      {"pairs", CellKind::number, 4.4f, 2, &HudRow::pairs, &HudRow::pairs_value},
      {ratio, CellKind::number, 6.6f, 3, &HudRow::ratio, &HudRow::ratio_value,
       &HudRow::ratio_noisy},
      {"ms", CellKind::number, 5.2f, 4, &HudRow::ms, &HudRow::ms_value, &HudRow::is_noisy},
      {"unused", CellKind::number, 3.6f, 6, &HudRow::unused, &HudRow::unused_value},
      {"per visible", CellKind::number, 4.8f, 9, &HudRow::per_visible, &HudRow::per_visible_value},
  };
  if (const auto other = other_pipeline(viewer)) {
    const char* name = kPipelineNames[static_cast<int>(*other)];
    columns.push_back({fmt::format("{} ms", name), CellKind::number, 5.4f, 7, &HudRow::other_ms,
                       &HudRow::other_ms_value, &HudRow::other_noisy});
    columns.push_back({fmt::format("{} {}", name, ratio), CellKind::number, 7.6f, 8,
                       &HudRow::other_ratio, &HudRow::other_ratio_value,
                       &HudRow::other_ratio_noisy});
  }
  columns.push_back({"stages", CellKind::stages, 5.0f, 5});
  return columns;
}

namespace {

// "\u00b1" and "%" mean something else to LaTeX.
std::string latex_cell(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 2, "\u00b1") == 0) {
      result += "$\\pm$";
      ++i;
    } else {
      if (std::string_view("%&_#$").find(text[i]) != std::string_view::npos) result += '\\';
      result += text[i];
    }
  }
  return result;
}

std::vector<std::string> cells_of(const HudRow& row, const std::vector<TableColumn>& columns) {
  std::vector<std::string> cells;
  for (const TableColumn& column : columns)
    cells.push_back(column.text == nullptr ? row.name : row.*column.text);
  return cells;
}

std::string latex_line(std::vector<std::string> cells) {
  for (std::string& cell : cells) cell = latex_cell(cell);
  return joined(cells, " & ") + " \\\\\n";
}

std::string markdown_line(std::vector<std::string> cells) {
  for (std::string& cell : cells) cell = markdown_text(cell);
  return "| " + joined(cells, " | ") + " |\n";
}

}  // namespace

std::string table_text(const Viewer& viewer, TableFormat format) {
  if (format == TableFormat::csv) return format_csv(viewer.numbers.rows);
  std::vector<TableColumn> columns = table_columns(viewer);
  std::erase_if(columns, [](const TableColumn& column) { return column.kind == CellKind::stages; });
  const std::vector<std::string> titles = titles_of(columns);
  const std::string about = table_caption(viewer);
  const auto count = columns.size();
  std::string text;
  if (format == TableFormat::markdown) {
    text = about + "\n\n" + markdown_line(titles) + "|---|";
    for (std::size_t i = 1; i < count; ++i) text += "---:|";
    text += "\n";
    for (const HudRow& row : hud_rows(viewer)) text += markdown_line(cells_of(row, columns));
    return text;
  }
  text = "% " + about + "\n\\begin{tabular}{l" + std::string(count - 1, 'r') + "}\n";
  text += latex_line(titles) + "\\hline\n";
  for (const HudRow& row : hud_rows(viewer)) text += latex_line(cells_of(row, columns));
  return text + "\\end{tabular}\n";
}

std::string table_caption(const Viewer& viewer) {
  const std::vector<BenchRow>& rows = viewer.numbers.rows;
  const Camera camera = measured_camera(viewer);
  const glm::ivec2 size = rows.empty() ? glm::ivec2(camera.width, camera.height)
                                       : glm::ivec2(rows.front().width, rows.front().height);
  return fmt::format("{}, {} x {}, {}", viewer.scene ? viewer.scene->name : "no scene", size.x,
                     size.y, drawn_by(viewer.variant()));
}

}  // namespace qs
