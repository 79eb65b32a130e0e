// SPDX-License-Identifier: MIT
//
// What is drawn over the picture. A panel reads the viewer and appends actions, nothing else. To
// add one: a file here with its function, a switch in Panels, a row of kBindings, its call in
// panels.cpp.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/viewer/state/actions.h"

namespace qs {

/// What panels keep between frames and the viewer has no use for.
struct PanelMemory {
  std::filesystem::path folder;                ///< of the open window
  std::vector<std::filesystem::path> entries;  ///< folders and readable files in it
  std::string typed;                           ///< path being typed
  unsigned photograph = 0;                     ///< GL texture, 0 = none
  std::filesystem::path photograph_path;       ///< of which picture it is
  double photograph_aspect = 1;                ///< width / height
  unsigned construction = 0;                   ///< GL texture of the inspector's, 0 = none
  bool inspected_anew = false;                 ///< the inspector shows it for the first time
  glm::dvec2 cursor{-1};                       ///< pixels of the picture
  Scale heat_scale;                            ///< of the map on show
};

/// Everything that is open. Called between Window::begin_ui() and end_ui().
void draw_panels(const Viewer& viewer, PanelMemory& memory, Actions& actions);

/// Which cell of a map over the picture is under the mouse, by rows; unset beside the picture or
/// over a panel. `cell_px`: its side in the window.
std::optional<std::size_t> cell_under_mouse(const PanelMemory& memory, int cell_px, int columns,
                                            int rows);

/// Is the mouse over the picture and not over a panel?
bool mouse_is_free();

// ---- one file each
// -------------------------------------------------------------------------------
float draw_menu_bar(const Viewer& viewer, Actions& actions);  ///< its height
void draw_hud(const Viewer& viewer, Actions& actions, float top);
void draw_heat_legend(const Viewer& viewer, const PanelMemory& memory);
void draw_info(const Viewer& viewer, Actions& actions, float top);
void draw_help(const Viewer& viewer, Actions& actions);
void draw_cameras(const Viewer& viewer, Actions& actions, float top);
void draw_recorder(const Viewer& viewer, Actions& actions, float top);
void draw_inspector(const Viewer& viewer, PanelMemory& memory, Actions& actions, float top);
void draw_split(const Viewer& viewer, const PanelMemory& memory, Actions& actions, float top);
void draw_divider(const Viewer& viewer, Actions& actions, float top);  ///< of the split picture
void draw_open(const Viewer& viewer, PanelMemory& memory, Actions& actions);
void draw_overlay(const Viewer& viewer, const PanelMemory& memory);
void draw_messages(const Viewer& viewer, Actions& actions);
void draw_welcome(const Viewer& viewer, Actions& actions);

}  // namespace qs
