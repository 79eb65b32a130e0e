// SPDX-License-Identifier: MIT
//
// What the program asks about culling modes at run time. The answers are those of table.h, which
// only mode.cpp and the code of the modes include.
#pragma once

#include <string_view>

#include "raster/kernel/cull/row.h"

namespace qs {

/// Modes 1..culler_count() are `--cull all`.
int culler_count();

/// Modes culler_count() + 1..mode_count() are those of other papers.
int mode_count();

/// The row of a mode, 0..mode_count().
const CullerRow& row_of(CullMode mode);

/// The name of a mode, 0..mode_count(), on the command line.
const char* mode_name(CullMode mode);

/// The mode with this name; -1 if none has it.
CullMode find_culler(std::string_view name);

/// `quadbox`.
CullMode default_mode();

}  // namespace qs
