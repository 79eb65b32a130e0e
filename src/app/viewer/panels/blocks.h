// SPDX-License-Identifier: MIT
//
// Draws the blocks of a panel (panel_model.h) in the window.
#pragma once

#include "app/viewer/panels/controls_drawer.h"
#include "app/viewer/panels/panels.h"

namespace qs {

void draw_blocks(const Blocks& blocks, const Viewer& viewer, PanelState& state, Actions& actions);

// The larger blocks, a file each.
void draw_table(const block::Table& table, PanelState& state, const ControlsDrawer& controls);
void draw_chart(const block::Chart& chart);
void draw_color_bar(const Legend& legend);

/// Names in their colours in a line.
void draw_keys(const std::vector<block::Key>& keys);

}  // namespace qs
