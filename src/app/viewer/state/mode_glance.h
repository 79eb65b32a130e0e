// SPDX-License-Identifier: MIT
//
// The words over the picture about the mode: after a switch what it changed in this view, and the
// badge that can stay.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/viewer/state/viewer.h"

namespace qs {

/// The numbers of a mode in the view in the window; unset if they are unknown.
struct ModeGlance {
  std::optional<double> fps;
  std::optional<std::uint64_t> pairs;
};

/// The numbers of two modes from one source, so that they can be compared: both rows of the table
/// if it is of this view, else the full-size frames of this view that were shown.
struct GlancePair {
  ModeGlance from, to;
};
GlancePair glances_of(const Viewer& viewer, CullMode from, CullMode to);

/// "FPS 512 -> 1,040, pairs 5,227,642 -> 1,796,352" of Viewer::mode_switch, which must be set; "-"
/// for unknown numbers, empty if all are unknown.
std::string switch_text(const Viewer& viewer);

/// grid_label() with `counted` pairs until the table has them.
std::string mode_label(const Viewer& viewer, CullMode mode, std::optional<std::uint64_t> counted);

/// The numbers below a mode's picture in the grid: "1,040 FPS, 1,796,352 pairs, 2.03x"; FPS and the
/// ratio are "-" until the table has them.
std::string grid_label(const Viewer& viewer, CullMode mode);

/// The lines of the badge below the name: "1,040 FPS" and "1,796,352 pairs", as far as known.
std::vector<std::string> badge_lines(const Viewer& viewer);

}  // namespace qs
