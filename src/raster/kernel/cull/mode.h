// SPDX-License-Identifier: MIT
//
// The table of culling modes at run time. Code that needs the table at compile time, for example as
// the size of an array, includes table.h; a new row recompiles that code.
#pragma once

#include <string_view>

#include "raster/kernel/cull/row.h"

namespace qs {

/// Modes 1..culler_count() are `--cull all`.
int culler_count();

/// Modes culler_count() + 1..mode_count() come from other papers.
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
