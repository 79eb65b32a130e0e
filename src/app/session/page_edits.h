// SPDX-License-Identifier: MIT
//
// Carries out edits on the pages of a tree with levels of detail (docs/lod.md, Edits).
#pragma once

#include <string>
#include <vector>

#include "io/cloud/scene.h"
#include "raster/pages/page_stream.h"
#include "raster/select/edit_step.h"

namespace qs {

/// The edit of a page by these steps. Leaves that are gone have no opacity; a merged node is gone
/// if its centre is. While its ball is larger than a pixel, a merged node with leaves on both sides
/// of a border is opened before all others; a node whose leaves are all gone has no children.
/// With lists merged nodes follow their leaves. If the footprint of the tree is 0,
/// nodes have no balls around their leaves, and only centres decide. `source` names the steps'
/// file, `tree` is a scene with a stream. Throws Error(usage) if a step needs the whole scene.
PageEdit page_editor(std::vector<EditStep> steps, const std::string& source, const Scene& tree);

}  // namespace qs
