// SPDX-License-Identifier: MIT
//
// tests/vectors/cull.json: footprints with the tiles that each mode lists, by independent
// arithmetic. docs/check_your_port.md describes the format.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs::test {

/// Tiles that must be listed, and tiles that rounding may add.
struct TileMap {
  std::set<int> must, may;

  /// "" if `listed` is right, else the first tile that is missing or wrong.
  std::string fault_of(const std::set<int>& listed) const;
};

struct CullVector {
  std::string name;
  int width = 0, height = 0;
  TileGrid grid;
  Footprint footprint;
  float opacity = 0;
  std::map<std::string, TileMap> maps;
};

struct CullVectors {
  std::map<std::string, std::string> map_of_mode;
  std::vector<CullVector> all;

  const CullVector& named(const std::string& name) const;
};

CullVectors read_cull_vectors();

}  // namespace qs::test
