// SPDX-License-Identifier: MIT
//
// The prims of a .usda stage that matter for Gaussians: their place in the tree, their transforms,
// and the arrays of splats.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/mat4x4.hpp>

#include "base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

enum UsdArray { kUsdPositions, kUsdRotations, kUsdScales, kUsdOpacities, kUsdSh, kUsdArrays };

/// The arrays of one prim, as they stand in the file.
struct UsdSplats {
  std::string prim;  ///< its path
  std::array<std::optional<Array<float>>, kUsdArrays> values{};
  int sh_degree = 3;    ///< as the schema's default
  glm::dmat4 world{1};  ///< from the prim's space

  std::size_t count() const {
    const auto& positions = values[kUsdPositions];
    return positions ? positions->size() / 3 : 0;
  }
};

struct UsdStage {
  bool z_is_up = false;
  std::vector<UsdSplats> splats;  ///< of prims that are shown, in the order of the file
  std::vector<std::string> warnings;
};

/// `source` names the file in messages. Throws Error(input).
UsdStage parse_usda(std::string_view text, const std::string& source, const Progress& progress);

}  // namespace qs
