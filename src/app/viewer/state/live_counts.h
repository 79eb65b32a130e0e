// SPDX-License-Identifier: MIT
//
// The tile pairs of all culling modes in the view in the window. Frames count them beside drawing
// (Outputs::mode_pairs), always for the full size of the picture, so a count is exact even where
// the frame in the window is reduced. While the camera moves some frames may not count.
#pragma once

#include <optional>

#include "app/viewer/state/viewer.h"

namespace qs {

/// A count is unknown if more frames of other views than this were shown after it.
inline constexpr int kMostFramesAgo = 10;

/// The size of a mode's own frame.
struct LiveCount {
  std::uint64_t tile_pairs = 0;
  std::uint32_t visible = 0;
  int frames_ago =
      0;  ///< 0: exact for the view in the window; else of the view that many frames ago
};

/// The count of a mode; unset if it is unknown, and for other modes than 1..culler_count().
std::optional<LiveCount> live_pairs(const Viewer& viewer, CullMode mode);

/// True if the table of modes is visible, so that frames count.
bool shows_counts(const Viewer& viewer);

/// True if the counts are of the view of the next frame.
bool counts_are_current(const Viewer& viewer);

}  // namespace qs
