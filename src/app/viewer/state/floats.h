// SPDX-License-Identifier: MIT
//
// The places of messages, progress, legends, plates, captions and hints, which float over the
// picture. One function places all of them, so that no two overlap.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "app/viewer/state/layout.h"

namespace qs {

/// From the most important kind to the least: if there is no room for all, later ones give way.
enum class FloatKind {
  choice,   ///< the strip of first views
  message,  ///< several: the first is the newest
  progress,
  legend,
  plate,  ///< the mode after a switch
  badge,  ///< the mode and its numbers
  photograph,
  left_name,   ///< of the left side of a split; its place is the upper right corner
  right_name,  ///< its place is the upper left corner
  name,        ///< of the only side that is seen
  cell,        ///< a picture of the grid of all modes, which others cover only if they must
  caption,     ///< of a cell; it never moves
  way,         ///< back to the subject
  hints
};

/// All in screen units.
struct Floating {
  FloatKind kind = FloatKind::message;
  glm::vec2 size{0.0f};
  glm::vec2 smaller{0.0f};           ///< the size if there is no room for the other; 0: none
  std::optional<glm::vec2> at = {};  ///< wished place of the kind's anchor; unset: the usual place
};

/// Disjoint rectangles inside of the picture, in the order of `shown`; an empty one has no room and
/// is not drawn. `gap`: least distance between two, and to the edges.
std::vector<Rect> floats_of(const Rect& picture, float gap, std::span<const Floating> shown);

}  // namespace qs
