// SPDX-License-Identifier: MIT
//
// The places of equal pictures in a page of their own aspect, with room for a label below each. All
// lengths are shares of the page's width or height, so that they hold at every size.
#pragma once

#include <glm/vec2.hpp>

namespace qs {

struct GridPlaces {
  int columns = 1, rows = 1;
  float side = 1;   ///< a picture's share of the width and of the height, > 0
  float label = 0;  ///< height of a label

  /// The top left of picture `index`, which is centred in its column. Rows begin at the top of the
  /// page, so that the room that is left over is at its bottom.
  glm::vec2 low(int index) const;
};

/// The arrangement with the largest pictures. `count` > 0; `label`: height of a label, 0 to 0.3.
GridPlaces grid_places(int count, float label);

}  // namespace qs
