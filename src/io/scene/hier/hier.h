// SPDX-License-Identifier: MIT
//
// .hier (hierarchical-3d-gaussians): a tree of levels of detail in one file, as floats or mostly as
// halves. The leaves are read. The file has no magic word: its size shows what it is. Source:
// hierarchy_loader.cpp and types.h of graphdeco-inria/gaussian-hierarchy; the code is our own.
#pragma once

#include "io/cloud/scene.h"

namespace qs {

RecogniseScene recognises_hier;
ReadScene read_hier;

}  // namespace qs
