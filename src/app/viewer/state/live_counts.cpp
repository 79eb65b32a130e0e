// SPDX-License-Identifier: MIT
#include "app/viewer/state/live_counts.h"

namespace qs {

std::optional<LiveCount> live_pairs(const Viewer& viewer, CullMode mode) {
  const ViewCounts& counts = viewer.counts;
  if (mode < 1 || static_cast<std::size_t>(mode) > counts.modes.size()) return std::nullopt;
  const bool exact = counts.view_version == viewer.shown.view_version;
  const int frames_ago = exact ? 0 : viewer.frames - counts.frame;
  if (frames_ago > kMostFramesAgo) return std::nullopt;
  const ModePairs& pairs = counts.modes[static_cast<std::size_t>(mode - 1)];
  return LiveCount{pairs.tile_pairs, pairs.visible, frames_ago};
}

bool shows_counts(const Viewer& viewer) {
  return viewer.scene && !viewer.remote && viewer.panels.hud && viewer.panels.all;
}

bool counts_are_current(const Viewer& viewer) {
  return viewer.counts.view_version == viewer.view_version;
}

}  // namespace qs
