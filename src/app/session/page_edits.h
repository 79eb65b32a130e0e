// SPDX-License-Identifier: MIT
//
// Carries out edits on the pages of a tree with levels of detail (docs/lod.md, Edits).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "raster/pages/cut.h"
#include "raster/select/edit_step.h"

namespace qs {

/// The change of a page by these steps. Leaves that are gone have no opacity; a merged node is gone
/// if its centre is. While its ball is larger than a pixel, a merged node with leaves on both sides
/// of a border is opened before all others; a node whose leaves are all gone has no children.
/// `footprint`: of the tree; if it is 0, nodes have no balls around their leaves, and only centres
/// decide. `source` names the steps' file. Throws Error(usage) if a step needs the whole scene.
std::function<void(LodPage&)> page_editor(std::vector<EditStep> steps, const std::string& source,
                                          float footprint);

}  // namespace qs
