// SPDX-License-Identifier: MIT
//
// The construction of every mode around one Gaussian, drawn to scale on the frame that it is part
// of: ellipse, square and boxes on the grid of tiles, QPass line by line, and the tiles of each
// mode side by side with what became of them.
#pragma once

#include <string>

#include "app/inspect/inspection.h"
#include "raster/scene/image.h"

namespace qs {

struct ConstructionInput {
  const Inspection& inspection;  ///< with a picked Gaussian
  const Image& color;            ///< the frame
  TileGrid grid;
  std::string where;  ///< scene and view, for the headline
};

/// A picture 1800 pixels wide.
Image draw_construction(const ConstructionInput& input);

}  // namespace qs
