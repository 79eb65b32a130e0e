// SPDX-License-Identifier: MIT
//
// The number of a culling mode, and what a row of their table says about one.
#pragma once

#include <cstdint>

namespace qs {

/// Row of a mode in table.h: 1.. for ours, then other papers', or 0 for the fp64 reference (CPU
/// only).
using CullMode = int;
inline constexpr CullMode kReferenceMode = 0;

/// The table has the families in this order.
enum class CullerFamily {
  reference,
  quadbox,  ///< `--cull all`, and the viewer's keys 1, 2, 3, ...
  peers     ///< modes of other papers, which tables show on request (`--cull all,+peers`)
};

struct CullerRow {
  const char* name;     ///< on the command line, in the viewer, in files; kName of its struct
  const char* summary;  ///< one clause for tables and help
  CullerFamily family;
  std::uint32_t color;       ///< 0xRRGGBB in drawings and plots; no other mode has it
  bool lossless = false;     ///< lists every tile with a pixel of alpha >= 1/255
  bool keeps_faint = false;  ///< also lists Gaussians of opacity <= 1/255
};

}  // namespace qs
