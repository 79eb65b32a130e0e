// SPDX-License-Identifier: MIT
//
// The table of culling modes: the name and properties of each, without its code. All texts, keys,
// colours and loops over modes take them from here, at run time through mode.h, so that a new row
// recompiles little. modes.h has the structs of the modes and proves that both agree. To add a
// mode, write its row behind the last one of its family.
#pragma once

#include <iterator>
#include <string_view>

#include "raster/kernel/cull/row.h"

namespace qs {

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

inline constexpr int kModeCount = static_cast<int>(std::size(kCullers)) - 1;

inline constexpr int kCullerCount = [] {
  int count = 0;
  for (const CullerRow& row : kCullers) count += row.family == CullerFamily::quadbox ? 1 : 0;
  return count;
}();
static_assert(kCullerCount <= 9, "every mode has a key of one digit in the viewer, and 0 is taken");

static_assert(
    [] {
      for (CullMode mode = 0; mode <= kModeCount; ++mode)
        if (kCullers[mode].family != (mode == kReferenceMode ? CullerFamily::reference
                                      : mode <= kCullerCount ? CullerFamily::quadbox
                                                             : CullerFamily::peers))
          return false;
      return true;
    }(),
    "the table starts with the reference, and other papers' modes follow behind ours");

/// The mode with this name; -1 if none has it.
constexpr CullMode number_of(std::string_view name) {
  for (int mode = 0; mode <= kModeCount; ++mode)
    if (name == kCullers[mode].name) return mode;
  return -1;
}

}  // namespace qs
