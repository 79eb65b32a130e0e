// SPDX-License-Identifier: MIT
//
// meta.json of a SOG scene in one form for versions 1 and 2: the picture that holds each value, and
// the meaning of its bytes.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <glm/vec3.hpp>

namespace qs {

using ByteTable = std::array<float, 256>;

struct SogMeta {
  int version = 0;          ///< 1 or 2
  std::uint64_t count = 0;  ///< Gaussians, at least 1
  /// Bounds of positions p, stored as sign(p) ln(|p| + 1), finite.
  glm::dvec3 position_low{0}, position_high{0};
  std::array<ByteTable, 3> log_scale, dc;  ///< index: axis, colour channel
  ByteTable logit;                         ///< index: alpha
  std::string positions_low, positions_high, scales, rotations, colors;  ///< file names

  int sh_bands = 0;  ///< 0 none, 1..3; -1: given by the width of `centroids` (version 1)
  std::uint64_t sh_palette = 0;  ///< rows of coefficients in `centroids`; 0: as many as fit
  ByteTable sh;
  std::string centroids, labels;
};

/// `source` names the file in messages. Throws Error(input).
SogMeta parse_sog_meta(std::string_view text, const std::string& source);

}  // namespace qs
