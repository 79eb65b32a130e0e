// SPDX-License-Identifier: MIT
#include "app/viewer/state/mode_table.h"

#include <cmath>

#include <fmt/format.h>

#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/samples.h"
#include "base/list_of.h"
#include "base/text.h"

namespace qs {
namespace {

HudCell time_cell(const BenchRow& row) {
  return {time_text(row.ms_median, spread_ms(row)), row.ms_median, has_noisy_time(row)};
}

// A ratio of interleaved frames can be certain although the times of a busy machine vary.
HudCell ratio_cell(const Viewer& viewer, const BenchRow* row, Pipeline pipeline) {
  const std::optional<Ratio> ratio = ratio_to_baseline(viewer, row, pipeline);
  return ratio ? HudCell{ratio_text(*ratio), ratio->value, is_undecided(*ratio)} : HudCell();
}

void set_measured(HudRow& row, const BenchRow& measured) {
  const std::optional<double> spread = spread_ms(measured);
  row.ms = time_cell(measured);
  row.fps = {rate_text(measured.ms_median, spread), measured.fps_median, row.ms.noisy};
  row.pairs = {grouped(measured.pairs), static_cast<double>(measured.pairs)};
  row.per_visible = {fmt::format("{:.2f}", measured.pairs_per_visible), measured.pairs_per_visible};
  row.unused = {unused_text(&measured), measured.false_positive_share.value_or(0)};
  if (!spread || *spread >= measured.ms_median) return;
  row.fps_low = 1000 / (measured.ms_median + *spread);
  row.fps_high = 1000 / (measured.ms_median - *spread);
}

// Rates and counts of the view in the window, until its modes are measured: nothing of a row is of
// an earlier view. `base`: the rate of Viewer::baseline.
void set_live(const Viewer& viewer, const std::optional<LiveRate>& base, HudRow& row) {
  row.is_live = true;
  if (const std::optional<LiveCount> live = live_pairs(viewer, row.mode)) {
    row.pairs = {count_text(*live), static_cast<double>(live->tile_pairs)};
    if (live->visible > 0) {
      const double each = row.pairs.value / live->visible;
      row.per_visible = {fmt::format("{:.2f}", each), each};
    }
  }
  const std::optional<LiveRate> rate = live_rate(viewer, row.mode);
  if (!rate) return;
  row.fps = {live_text(*rate), rate->fps};
  row.ms = {"~" + rough(1000 / rate->fps), 1000 / rate->fps};
  if (base) row.ratio = {"~" + rough(rate->fps / base->fps) + "x", rate->fps / base->fps};
}

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
  return list_of<std::string>(columns, [&](const auto& each) { return (row.*each.cell).text; });
}

std::string latex_line(const std::vector<std::string>& cells) {
  return joined(list_of<std::string>(cells, latex_cell), " & ") + " \\\\\n";
}

std::string markdown_line(const std::vector<std::string>& cells) {
  return "| " + joined(list_of<std::string>(cells, markdown_text), " | ") + " |\n";
}

}  // namespace

std::optional<Pipeline> other_pipeline(const Viewer& viewer) {
  if (pipelines_of(viewer.backend).size() < 2) return std::nullopt;
  return viewer.settings.pipeline == Pipeline::fast ? Pipeline::classic : Pipeline::fast;
}

std::string unused_text(const BenchRow* row) {
  if (row == nullptr || !row->false_positives) return "-";
  return fmt::format("{:.1f} %", 100 * row->false_positive_share.value_or(0));
}

std::vector<HudRow> hud_rows(const Viewer& viewer) {
  const Pipeline here = viewer.settings.pipeline;
  const std::optional<Pipeline> other = other_pipeline(viewer);
  const bool is_current = numbers_are_current(viewer);
  const auto base = is_current ? std::nullopt : live_rate(viewer, viewer.baseline);
  std::vector<HudRow> rows;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    HudRow& row = rows.emplace_back();
    row.mode = mode;
    row.name = {mode_name(mode), static_cast<double>(mode)};
    if (!is_current) {
      set_live(viewer, base, row);
      continue;
    }
    const BenchRow* found = measured_row(viewer, mode, here);
    if (found != nullptr) set_measured(row, *found);
    row.ratio = ratio_cell(viewer, found, here);
    if (!other) continue;
    const BenchRow* beside = measured_row(viewer, mode, *other);
    row.other_ms = beside == nullptr ? HudCell() : time_cell(*beside);
    row.other_ratio = ratio_cell(viewer, beside, *other);
  }
  return rows;
}

std::string trust_text(const Viewer& viewer, CullMode mode) {
  const Pipeline here = viewer.settings.pipeline;
  const BenchRow* row = measured_row(viewer, mode, here);
  const bool is_current = numbers_are_current(viewer);
  if (!is_current && live_rate(viewer, mode))
    return fmt::format("~ is of at least {} frames, each beside a picture in the window",
                       kPairsOfMode);
  if (row == nullptr || !is_current) return "not measured yet";
  const std::size_t frames = rounds_of(*row).size();
  std::string text = fmt::format("median of {} frame{}", frames, frames == 1 ? "" : "s");
  if (const std::optional<double> spread = spread_ms(*row))
    text +=
        fmt::format("; the middle half of them spans {} ms", significant(2 * *spread, 2 * *spread));
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
  using enum CellKind;
  std::vector<TableColumn> columns = {
      {"mode", mode, 6.6f, 0, &HudRow::name},
      {"FPS", bar, 5.4f, 1, &HudRow::fps},
      {"pairs", number, 4.4f, 2, &HudRow::pairs},
      {ratio, number, 5.9f, 3, &HudRow::ratio},
      {"ms", number, 5.2f, 4, &HudRow::ms},
      {"unused", number, 3.6f, 6, &HudRow::unused},
      {"per visible", number, 4.8f, 9, &HudRow::per_visible},
  };
  if (const auto other = other_pipeline(viewer)) {
    const char* name = kPipelineNames[static_cast<int>(*other)];
    columns.push_back({fmt::format("{} ms", name), number, 5.4f, 7, &HudRow::other_ms});
    columns.push_back({fmt::format("{} {}", name, ratio), number, 7.6f, 8, &HudRow::other_ratio});
  }
  columns.push_back({"stages", stages, 5.0f, 5});
  return columns;
}

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

std::string numbers_size(const Viewer& viewer) {
  if (!numbers_are_current(viewer) || viewer.numbers.rows.empty())
    return fmt::format("{} x {}{}", viewer.camera.width, viewer.camera.height,
                       size_text(viewer.shown.divisor));
  const BenchRow& row = viewer.numbers.rows.front();
  return fmt::format("{} x {}", row.width, row.height);
}

std::string table_caption(const Viewer& viewer) {
  const std::string altered = alterations_of(viewer).text;
  return fmt::format("{}, {}, {}{}", viewer.scene ? viewer.scene->name : "no scene",
                     numbers_size(viewer), drawn_by(viewer.variant()),
                     altered.empty() ? "" : ", " + altered);
}

std::string switch_text(const Viewer& viewer) {
  const std::vector<HudRow> rows = hud_rows(viewer);
  const auto row_of = [&](CullMode mode) { return rows[static_cast<std::size_t>(mode - 1)]; };
  const HudRow from = row_of(viewer.mode_switch->from), to = row_of(viewer.mode_switch->to);
  if (from.pairs.value == 0 && to.pairs.value == 0) return "";
  const auto fps_of = [&](const HudRow& row) {  // one pair is drawn at once
    const auto rate = row.fps.value == 0 ? live_rate(viewer, row.mode, 1) : std::nullopt;
    return rate && row.is_live ? live_text(*rate) : row.fps.text;
  };
  const std::string before = fps_of(from), after = fps_of(to),
                    pairs = fmt::format("pairs {} -> {}", from.pairs.text, to.pairs.text);
  if (before == "-" && after == "-") return pairs;  // under a heat map in flight
  return fmt::format("FPS {} -> {}, {}", before, after, pairs);
}

std::string grid_label(const Viewer& viewer, CullMode mode) {
  const std::optional<ShownGrid>& grid = viewer.shown.grid;
  if (!grid || viewer.shown.divisor > 1) return mode_label(viewer, mode, std::nullopt);
  return mode_label(viewer, mode, grid->stats[static_cast<std::size_t>(mode - 1)].tile_pairs);
}

std::string mode_label(const Viewer& viewer, CullMode mode, std::optional<std::uint64_t> counted) {
  const HudRow row = hud_rows(viewer)[static_cast<std::size_t>(mode - 1)];
  const std::string pairs = counted && row.is_live ? grouped(*counted) : row.pairs.text;
  return fmt::format("{} FPS \u00b7 {} pairs \u00b7 {}", row.fps.text, pairs, row.ratio.text);
}

}  // namespace qs
