// SPDX-License-Identifier: MIT
//
// The table of culling modes: the number, name and properties of each, without its code. All texts,
// keys, colours and loops over modes take them from here. modes.h has the structs of the modes and
// proves that both agree. To add a mode, write its row behind the last one of its family.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string_view>

namespace qs {

/// Index of a mode in kCullers: 1..kCullerCount, kCullerCount + 1..kModeCount for other papers'
/// modes, or 0 for the fp64 reference (CPU only).
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

/// Index = CullMode. Other papers' modes are paler than ours.
inline constexpr CullerRow kCullers[] = {
    {.name = "reference",
     .summary = "fp64 without tiles, the image the others are judged against",
     .family = CullerFamily::reference,
     .color = 0x009E73,
     .lossless = true},

    {.name = "3dgs",
     .summary = "square of 3 standard deviations, cuts what lies beyond",
     .family = CullerFamily::quadbox,
     .color = 0x000000,
     .keeps_faint = true},
    {.name = "adr",
     .summary = "tight axis-aligned box of the visible ellipse",
     .family = CullerFamily::quadbox,
     .color = 0xE69F00,
     .lossless = true},
    {.name = "dualbox",
     .summary = "only the two boxes along the major axis, loses quality",
     .family = CullerFamily::quadbox,
     .color = 0x56B4E9},
    {.name = "quadbox-naive",
     .summary = "the same four boxes looped one by one, without QPass",
     .family = CullerFamily::quadbox,
     .color = 0xCC79A7,
     .lossless = true},
    {.name = "quadbox",
     .summary = "four boxes hugging the ellipse, walked in one pass (QPass)",
     .family = CullerFamily::quadbox,
     .color = 0x0072B2,
     .lossless = true},
    {.name = "exact",
     .summary = "tiles whose pixel centres the ellipse really meets, the lower bound",
     .family = CullerFamily::quadbox,
     .color = 0xD55E00,
     .lossless = true},

    {.name = "snugbox",
     .summary = "Speedy-Splat: box of the visible ellipse from its conic, loses parts of needles",
     .family = CullerFamily::peers,
     .color = 0x8FC9A0},
    {.name = "accutile",
     .summary = "Speedy-Splat: tiles of SnugBox that the ellipse spans in their line, loses parts "
                "of needles",
     .family = CullerFamily::peers,
     .color = 0x8C6D31},
    {.name = "flashgs",
     .summary = "FlashGS: tiles whose rectangle meets the ellipse, loses parts of needles",
     .family = CullerFamily::peers,
     .color = 0xA39BD0},
    {.name = "stopthepop",
     .summary = "StopThePop: tiles in which alpha reaches 1/255, of a square, loses parts of "
                "needles",
     .family = CullerFamily::peers,
     .color = 0xC9B458},
    {.name = "faster-gs",
     .summary = "Faster-GS: tiles in which alpha reaches 1/255, of a tight box, loses parts of "
                "needles",
     .family = CullerFamily::peers,
     .color = 0xB5838D},
};

constexpr const CullerRow& row_of(CullMode mode) {
  return kCullers[static_cast<std::size_t>(mode)];
}

/// The mode's name on the command line.
constexpr const char* mode_name(CullMode mode) { return row_of(mode).name; }

inline constexpr int kModeCount = static_cast<int>(std::size(kCullers)) - 1;

inline constexpr int kCullerCount = [] {
  int count = 0;
  for (const CullerRow& row : kCullers) count += row.family == CullerFamily::quadbox ? 1 : 0;
  return count;
}();

static_assert(
    [] {
      for (CullMode mode = 0; mode <= kModeCount; ++mode) {
        if (row_of(mode).family != (mode == kReferenceMode ? CullerFamily::reference
                                    : mode <= kCullerCount ? CullerFamily::quadbox
                                                           : CullerFamily::peers))
          return false;
      }
      return true;
    }(),
    "the table starts with the reference, and other papers' modes follow behind ours");

/// The mode with this name; -1 if none has it.
constexpr CullMode find_culler(std::string_view name) {
  for (int mode = 0; mode <= kModeCount; ++mode) {
    if (name == mode_name(mode)) return mode;
  }
  return -1;
}

inline constexpr CullMode kDefaultMode = find_culler("quadbox");

}  // namespace qs
