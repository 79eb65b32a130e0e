// SPDX-License-Identifier: MIT
//
// The panels over the picture. A panel reads the Viewer and appends actions; it changes nothing
// else. To add one: a file here with its function, a switch in Panels, its row in commands.cpp, its
// call in panels.cpp.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/viewer/commands/jobs.h"
#include "app/viewer/panels/file_chooser.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/panel_text.h"

namespace qs {

/// State of the panels themselves.
struct PanelState {
  FileChooser chooser;        ///< of the dialog Open
  std::string typed_early;    ///< before its path field had the keyboard
  bool focus_path = false;    ///< its path field asks for the keyboard
  bool scroll_files = false;  ///< to the selected row
  int inspections = 0;        ///< Viewer::inspections that the inspector scrolled to
  unsigned photograph = 0, construction = 0;  ///< GL textures of Viewer's pictures, 0 = none
};

/// Draws all open panels. Called between Window::begin_ui() and end_ui().
void draw_panels(const Viewer& viewer, PanelState& state, Actions& actions);

/// Index of the cell under the mouse in a map over the picture, row by row; unset outside of the
/// picture or over a panel. `cell_px`: side of a cell in the window.
std::optional<std::size_t> cell_under_mouse(const Viewer& viewer, int cell_px, int columns,
                                            int rows);

/// Text at the right end of a table's cell.
void right_aligned(const std::string& text);

/// Explains the control that was drawn last by the command that does the same, with its key.
void command_tooltip(const char* help);

// ---- one file each -----------------------------------------------------------------------------
float draw_menu_bar(const Viewer& viewer, Actions& actions);  ///< its height
void draw_hud(const Viewer& viewer, Actions& actions, float top);
void draw_heat_legend(const Viewer& viewer);
void draw_info(const Viewer& viewer, Actions& actions, float top);
void draw_help(const Viewer& viewer, Actions& actions);
void draw_cameras(const Viewer& viewer, Actions& actions, float top);
void draw_recorder(const Viewer& viewer, Actions& actions, float top);
void draw_inspector(const Viewer& viewer, PanelState& state, Actions& actions, float top);
void draw_split(const Viewer& viewer, Actions& actions, float top);
void draw_divider(const Viewer& viewer, Actions& actions, float top);       ///< of the split window
void draw_verdict(const Viewer& viewer, Actions& actions);                  ///< of the reference
void draw_open(const Viewer& viewer, PanelState& state, Actions& actions);  ///< modal
void draw_overlay(const Viewer& viewer, const PanelState& state);
void draw_messages(const Viewer& viewer, Actions& actions);
void draw_welcome(const Viewer& viewer, Actions& actions);

}  // namespace qs
