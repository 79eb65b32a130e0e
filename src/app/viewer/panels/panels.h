// SPDX-License-Identifier: MIT
//
// The window's drawings beside and over the picture. They read the Viewer and append actions; they
// change nothing else. The panels in the bars are drawn from panel_rows(); panel_model.h says how
// to add one.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/viewer/commands/jobs.h"
#include "app/viewer/panel_model/panel_model.h"
#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/file_chooser.h"
#include "app/viewer/panels/floats_drawing.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/layout.h"
#include "app/viewer/state/panel_text.h"

namespace qs {

/// State of the panels themselves.
struct PanelState {
  std::span<const PanelRow> rows = panel_rows();  ///< the panels in the bars
  FileChooser chooser;                            ///< of the dialog Open
  std::string typed_early;    ///< text that was typed before the path field had the keyboard
  bool focus_path = false;    ///< the first field of the dialog requests the keyboard
  std::string words;          ///< typed into the palette
  int chosen_command = 0;     ///< in the palette
  bool scroll_files = false;  ///< to the selected row
  bool focus_train = false;   ///< the first field of the dialog Train requests the keyboard
  std::string crop_file;      ///< typed name of the cropped scene
  std::map<std::string, int> scrolled;  ///< block::Table::version by name, when it was scrolled
  unsigned photograph = 0;              ///< GL texture of Viewer::photograph, 0 = none
  unsigned test_photograph = 0;         ///< GL texture of TestView::shown, 0 = none
  unsigned test_picture = 0;            ///< GL texture of TestComparison::picture, 0 = none
  unsigned candidates = 0;              ///< GL texture of ViewChoice::pictures, 0 = none
  unsigned thumbnail = 0;               ///< GL texture of the bundled scene's picture, 0 = none
  float thumbnail_aspect = 1;           ///< its width over its height
  Panels drawn;                      ///< the panels that were open when the window was drawn last
  std::vector<std::string> columns;  ///< of the table of modes when it was drawn last
  std::optional<float> legend_drag;  ///< screen units that the mouse moved since it took the legend
};

/// Draws all open panels. Called between Window::begin_ui() and end_ui().
void draw_panels(const Viewer& viewer, PanelState& state, Actions& actions);

/// The layout of this frame of the window.
Layout current_layout(const Viewer& viewer);

/// An invisible handle over `area` that is dragged. Returns the mouse's place while it is dragged.
/// `cursor`: an ImGuiMouseCursor.
std::optional<glm::vec2> draw_handle(const char* name, const Rect& area, int cursor);

/// A vertical line at `x` over the picture, with arrows to drag it by. Returns the mouse's x while
/// it is dragged.
std::optional<float> draw_divider_line(const char* name, const Rect& picture, float x);

/// Text at the right end of a table's cell.
void right_aligned(const std::string& text);

/// Continues the line if an item of this width still fits into it.
void same_line_if_fits(float width);

/// Begins a modal dialog in the middle of the window, at most as large as given, in letters.
/// `height` 0: of its content. False if it is not shown.
bool begin_dialog(const char* title, float width, float height, bool& open);

/// A field over the whole width that takes the keyboard when its dialog opens. ImGui keeps the text
/// of an active field, so a field with a new text needs another `identity`. True if it changed.
bool draw_first_field(PanelState& state, int identity, const char* hint, std::string& text);

/// The text, or shortened_middle() of it if it is wider.
std::string fitted(std::string text, float width);

/// Shows a tooltip beside the bar of the panel, so that it covers no row of it.
void tooltip_beside(const std::string& text);

/// Shows a tooltip for the control that was drawn last: the equivalent command and its key.
void command_tooltip(const char* help);

// ---- one file each -----------------------------------------------------------------------------
// Parts of panels in the bars:
/// In the panel Training: a photograph beside the model's picture. Nothing before the run has read
/// its photographs.
void draw_test_view(const Viewer& viewer, const PanelState& state, Actions& actions);
void draw_log(const Viewer& viewer, Actions& actions);

// Elsewhere:
// Functions that take Floats only add to it: Floats::draw() draws when all sizes are known.
void draw_grid_labels(const Viewer& viewer, Floats& floats);  ///< of the grid of all modes
void draw_mode_plate(const Viewer& viewer, Floats& floats);   ///< the mode over the picture
void draw_menu_bar(const Viewer& viewer, Actions& actions);
void draw_status_line(const Viewer& viewer, const Rect& area);
void draw_heat_scale_menu(const Viewer& viewer, Actions& actions);  ///< a submenu of View
void draw_heat_legend(const Viewer& viewer, PanelState& state, Floats& floats, Actions& actions);
void draw_help(const Viewer& viewer, Actions& actions);
/// Of the split window.
void draw_divider(const Viewer& viewer, Floats& floats, Actions& actions);
void draw_verdict(const Viewer& viewer, Actions& actions);                     ///< of the reference
void draw_open(const Viewer& viewer, PanelState& state, Actions& actions);     ///< modal
void draw_train(const Viewer& viewer, PanelState& state, Actions& actions);    ///< modal
void draw_palette(const Viewer& viewer, PanelState& state, Actions& actions);  ///< modal
void draw_leaving(const Viewer& viewer, Actions& actions);                     ///< modal
void draw_overlay(const Viewer& viewer, const PanelState& state, Floats& floats, Actions& actions);
void draw_messages(const Viewer& viewer, Floats& floats, Actions& actions);
void draw_welcome(const Viewer& viewer, const PanelState& state, Actions& actions);
void draw_hints(const Viewer& viewer, Floats& floats);
/// The arrow to the subject, if the user has lost it.
void draw_lost(const Viewer& viewer, Floats& floats);
void draw_view_choice(const Viewer& viewer, const PanelState& state, Floats& floats,
                      Actions& actions);  ///< the strip of first views

/// Draws the blocks of a panel (panel_model.h).
void draw_blocks(const Blocks& blocks, const Viewer& viewer, PanelState& state, Actions& actions);

// The larger blocks, a file each.
void draw_table(const block::Table& table, PanelState& state, const ControlsDrawer& controls);
void draw_chart(const block::Chart& chart);
void draw_color_bar(const Legend& legend);
float color_bar_height();

/// Names in their colours in a line.
void draw_keys(const std::vector<block::Key>& keys);

}  // namespace qs
