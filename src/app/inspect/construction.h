// SPDX-License-Identifier: MIT
//
// A drawing of the bounds of one Gaussian in every mode, to scale on its frame: the ellipse, the
// boxes of the modes on the tile grid, the lines that QPass walks, and for each mode its tiles with
// their PairUse.
#pragma once

#include <string>

#include "app/inspect/inspection.h"
#include "raster/scene/image.h"

namespace qs {

struct ConstructionInput {
  const Inspection& inspection;  ///< has a picked Gaussian
  const Image& color;            ///< the frame
  TileGrid grid;
  std::string where;  ///< scene and view for the headline
};

/// A picture 1800 pixels wide.
Image draw_construction(const ConstructionInput& input);

}  // namespace qs
