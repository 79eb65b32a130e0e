// SPDX-License-Identifier: MIT
//
// The functions that make the blocks of each panel. `viewer.scene` is set, except for the training.
#pragma once

#include "app/viewer/panel_model/panel_model.h"

namespace qs {

Blocks table_blocks(const Viewer& viewer);
Blocks split_blocks(const Viewer& viewer);
Blocks recorder_blocks(const Viewer& viewer);
Blocks training_blocks(const Viewer& viewer);
Blocks crop_blocks(const Viewer& viewer);
Blocks inspector_blocks(const Viewer& viewer);
Blocks camera_blocks(const Viewer& viewer);
Blocks settings_blocks(const Viewer& viewer);

/// Buttons and fields in a line, as far as they fit.
block::Controls in_line(std::vector<block::Placed> controls);

/// Fields below each other, `width` letters wide.
block::Controls fields(float width, std::vector<std::string> names);

}  // namespace qs
