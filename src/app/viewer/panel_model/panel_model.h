// SPDX-License-Identifier: MIT
//
// The panels as plain data, stated once for the window and for the page of `quadsplat serve`. A
// panel is a list of blocks, which a pure function makes of the viewer. The window draws blocks in
// app/viewer/panels/blocks.cpp; app/serve/panel_json.cpp turns them into JSON, which
// assets/serve/panels.js draws.
// To add a panel: a function that returns its blocks, a row in panel_rows(), a switch in Panels
// with its place in layout.h, and a command that opens it (commands.cpp). To add a kind of block:
// its struct here, and a drawing of it in each of the three files above.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "app/picture/legend.h"
#include "app/picture/palette.h"
#include "app/viewer/commands/controls.h"
#include "app/viewer/state/panel_text.h"

namespace qs {

enum class Tone { plain, faint, caution };

Ink ink_of(CullMode mode);

/// A click sets this control of the common table (controls.h).
struct Use {
  std::string control;
  double value = 0;
  std::size_t index = 0;
  std::string label = {};  ///< in a menu
};

namespace block {

struct Text {
  std::string text;
  Tone tone = Tone::plain;
  bool follows = false;  ///< on the line of the block before
};

/// A line between blocks.
struct Line {};

struct Facts {
  std::vector<Fact> facts;
};

struct Progress {
  const char* what;
  double share = 0;  ///< done, 0 to 1
};

/// `range`: the numbers "NAME, from" and "NAME, to" in one field. Pages draw all forms as usual.
enum class Form { usual, radio, small_button, range };

/// The width of a field that takes the rest of the line.
inline constexpr float kWholeLine = -0.01f;

/// A control of the common table, and its form in the window. Nothing is drawn of a control that is
/// of no use now.
struct Placed {
  std::string name;
  float width = 0;       ///< letters; negative: the rest of the line but for these; 0: usual
  bool follows = false;  ///< on the line of the control before, if it fits
  Form form = Form::usual;
  std::string title = {};                       ///< to its left, in place of its label
  std::optional<std::string> short_label = {};  ///< in the window
  std::optional<CullMode> mode = std::nullopt;  ///< the label has the colour of this mode
  double speed = 0;                             ///< of a range: change in a pixel of dragging
};

struct Controls {
  std::vector<Placed> controls;
  bool indented = false;
};

struct Key {
  std::string text;
  Ink ink;
};

/// The meaning of colours.
struct Keys {
  std::vector<Key> keys;
};

struct ColorBar {
  Legend legend;
};

struct Column {
  std::string title;
  float letters = 0;  ///< least width
  float share = 0;    ///< of the width that is left; 0: the column keeps its least width
  int rank = 0;       ///< a narrow table leaves out the columns with the highest rank
  bool is_left = false;
  bool is_ordering = false;  ///< a click on the title orders the rows by Cell::value
  bool descends = false;     ///< the first click puts the largest first
};

/// A bar behind a cell's text with a line for an interval; all are shares of the cell.
struct Bar {
  double value = 0, low = 0, high = 0;
  Ink ink;
};

struct Cell {
  std::string text = {};
  Tone tone = Tone::plain;
  double value = 0;  ///< orders the rows; 0 is unknown and comes last
  std::string tooltip = {};
  std::optional<Use> use = {};  ///< of a click
  bool is_button = false;       ///< else a click anywhere in the row counts
  std::optional<Bar> bar = {};
  std::vector<double> parts = {};  ///< a bar of the table's keys, shares of the cell
  std::optional<glm::vec3> swatch = std::nullopt;
};

struct Row {
  std::vector<Cell> cells;
  bool is_here = false;        ///< the chosen row
  std::vector<Use> menu = {};  ///< of a right click; the window's alone
};

struct Table {
  const char* name;
  std::vector<Column> columns = {};
  std::vector<Row> rows = {};
  std::vector<Key> keys = {};  ///< of the last column, if it fits
  std::string caption = {};
  bool has_head = true;
  int most_lines = 0;    ///< more are scrolled; 0: all are shown
  int version = 0;       ///< another one scrolls to the chosen row
  bool is_busy = false;  ///< the numbers are being measured
};

/// Long lists in the order of an index.
struct List {
  std::size_t count = 0;
  std::function<std::string(std::size_t index)> label;
  std::optional<std::size_t> chosen;
  const char* control;  ///< an item, set by a click
};

/// Rows of items, each with a control for every part.
struct Item {
  ControlKind kind;  ///< toggle, number, button; item: the row's name
  const char* control;
  std::string label;
  double value = 0, least = 0, most = 0;
};
struct Items {
  std::vector<std::vector<Item>> rows;  ///< a row's number is the index of its items
};

struct ChartPoint {
  double x = 0, y = 0, low = 0, high = 0;  ///< shares of the width, and of the height
  bool is_noisy = false;                   ///< has a ring
};
struct Curve {
  std::string name = {};
  Ink ink = {};
  std::vector<ChartPoint> points = {};
  bool is_dashed = false, has_bars = false, is_marked = true;
  float width = 2;
};
/// A filled column from the bottom.
struct ChartColumn {
  double x0 = 0, x1 = 0, y = 0;
  glm::vec3 color;
};
/// The values of the curves at a place.
struct Reading {
  struct Row {
    std::string name, value, beneath;  ///< `beneath`: of the dashed curve
    Ink ink;
  };
  double x = 0;
  std::string title;
  std::vector<Row> rows;
};
struct Chart {
  std::string title = {}, axis = {};          ///< of the vertical axis, above; of the lower axis
  std::vector<BarTick> across = {}, up = {};  ///< from the left, and from the bottom
  std::vector<Curve> curves = {};             ///< from back to front
  std::vector<ChartColumn> columns = {};
  std::function<std::optional<Reading>(double x)> reading = {};  ///< null: there are none
  float letters = 14;                                            ///< height
};

/// Shapes in coordinates of their own, drawn as large as they fit.
struct Shape {
  std::vector<glm::vec2> points;
  Ink ink;
  float opacity = 1;
  float width = 0;     ///< of the outline, screen units; 0: filled
  bool is_box = true;  ///< two points are opposite corners; else a line, or a closed outline
};
struct Figure {
  std::string name;
  glm::vec2 low, high;
  std::vector<Shape> shapes;
};

/// The last values of something that changes in every frame.
struct Plot {
  std::vector<float> values;
  std::string caption;
};

/// Parts that need textures, typed text or files of this machine: the window alone draws them.
enum class Local { test_view, crop_file, messages, bookmarks };

}  // namespace block

using Block = std::variant<block::Text, block::Line, block::Facts, block::Progress, block::Controls,
                           block::Keys, block::ColorBar, block::Table, block::List, block::Items,
                           block::Chart, block::Figure, block::Plot, block::Local>;
using Blocks = std::vector<Block>;

struct PanelRow {
  bool Panels::*open;
  const char* name;   ///< for the page
  const char* title;  ///< in the window
  Blocks (*blocks)(const Viewer& viewer);
};

/// The panels beside the picture. The window's order is in layout.h.
std::span<const PanelRow> panel_rows();

/// Index of the cell under the cursor in a map over the picture, row by row; unset beside the
/// picture. `cell_px`: side of a cell in the window.
std::optional<std::size_t> cell_under_cursor(const Viewer& viewer, int cell_px, int columns,
                                             int rows);

// The functions that make the blocks of each panel. `viewer.scene` is set, except for the training.

Blocks table_blocks(const Viewer& viewer);
Blocks split_blocks(const Viewer& viewer);
Blocks recorder_blocks(const Viewer& viewer);
Blocks training_blocks(const Viewer& viewer);
Blocks crop_blocks(const Viewer& viewer);
Blocks measure_blocks(const Viewer& viewer);
Blocks inspector_blocks(const Viewer& viewer);
Blocks camera_blocks(const Viewer& viewer);
Blocks settings_blocks(const Viewer& viewer);

/// Buttons and fields in a line, as far as they fit.
block::Controls in_line(std::vector<block::Placed> controls);

/// Fields below each other, `width` letters wide.
block::Controls fields(float width, std::vector<std::string> names);

}  // namespace qs
