// SPDX-License-Identifier: MIT
//
// The table of all modes, apart from its drawing: its rows, its columns at every width, its order
// and its text for other programs. To add a column: a text of HudRow and a row of table_columns().
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/viewer.h"
#include "base/list_of.h"

namespace qs {

/// A number of the table: "-" and 0 if it was not measured.
struct HudCell {
  std::string text = "-";
  double value = 0;    ///< orders the rows
  bool noisy = false;  ///< it should not be trusted, or it is open which mode is faster
};

/// One mode of the table.
struct HudRow {
  CullMode mode = 0;
  HudCell name, ms, fps, pairs, per_visible, unused, ratio;
  HudCell other_ms{""}, other_ratio{""};  ///< of other_pipeline(); empty without another pipeline
  double fps_low = 0, fps_high = 0;       ///< the middle half of the frames; 0 for live numbers
  bool is_live = false;  ///< of the picture in the window: live_rate(), live_pairs()
};

std::vector<HudRow> hud_rows(const Viewer& viewer);

/// The pipeline that is not used now; empty on a backend with only one pipeline.
std::optional<Pipeline> other_pipeline(const Viewer& viewer);

/// The share of pairs that no pixel used: "25.0 %"; "-" if it was not measured.
std::string unused_text(const BenchRow* row);

/// The reliability of a row's numbers, for a tooltip: frames, spread and interval.
std::string trust_text(const Viewer& viewer, CullMode mode);

/// The content of a column's cells.
enum class CellKind { mode, bar, number, stages };

struct TableColumn {
  std::string title;
  CellKind kind = CellKind::number;
  float letters = 0;                ///< least width, heights of a letter
  int rank = 0;                     ///< a narrow table leaves out the columns with the highest rank
  HudCell HudRow::*cell = nullptr;  ///< null for stages
};

/// All columns from left to right.
std::vector<TableColumn> table_columns(const Viewer& viewer);

/// The columns for a table of this width; `padding`: of a column. Both in heights of a letter. At
/// least the mode and FPS.
template <class Column>
std::vector<Column> columns_that_fit(std::vector<Column> columns, float width, float padding) {
  const auto used = [&] {
    float sum = 0;
    for (const Column& column : columns) sum += column.letters + padding;
    return sum;
  };
  while (columns.size() > 2 && used() > width)
    columns.erase(std::ranges::max_element(columns, {}, &Column::rank));
  return columns;
}

template <class Column>
std::vector<std::string> titles_of(const std::vector<Column>& columns) {
  return list_of<std::string>(columns, &Column::title);
}

/// Orders the rows by their values; rows with the value 0 come last.
template <class Row, class Value>
void sort_rows(std::vector<Row>& rows, const Value& value, bool descending) {
  std::ranges::stable_sort(rows, [&](const Row& a, const Row& b) {
    const double left = std::invoke(value, a), right = std::invoke(value, b);
    if (left == 0 || right == 0) return left != 0;
    return descending ? left > right : left < right;
  });
}

/// The forms in which the table is copied.
enum class TableFormat { csv, markdown, latex };

/// Index = TableFormat.
inline constexpr const char* kTableFormats[] = {"CSV", "Markdown", "LaTeX"};

/// The measured rows. CSV has all columns of bench.csv; the others have the table's columns and a
/// line with the scene, the size and the backend.
std::string table_text(const Viewer& viewer, TableFormat format);

/// The size of all numbers of the table: "1280 x 720", or "1280 x 720 at 1/2" of a reduced picture.
std::string numbers_size(const Viewer& viewer);

/// "garden, 1280 x 720, fast on CPU": the scene, numbers_size() and the backend.
std::string table_caption(const Viewer& viewer);

// ---- the words over the picture about the mode -------------------------------------------------
/// "FPS 512 -> 1,040, pairs 5,227,642 -> 1,796,352" of Viewer::mode_switch, which must be set: the
/// rows of the table, also in flight. "-" for unknown numbers, empty without pairs.
std::string switch_text(const Viewer& viewer);

/// grid_label() with `counted` pairs until the table has them.
std::string mode_label(const Viewer& viewer, CullMode mode, std::optional<std::uint64_t> counted);

/// The numbers below a mode's picture in the grid: "1,040 FPS, 1,796,352 pairs, 2.03x"; "-" for
/// unknown numbers.
std::string grid_label(const Viewer& viewer, CullMode mode);

}  // namespace qs
