// SPDX-License-Identifier: MIT
//
// A photograph as training compares it, with 8 bits per channel, in the host's memory.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "learn/gradient/loss.h"

namespace qs::train {

struct Photograph {
  std::span<const std::uint8_t> rgb;    ///< row by row; over black if `alpha` is not empty
  std::span<const std::uint8_t> alpha;  ///< per pixel; empty: opaque
  std::span<const std::uint8_t> mask;   ///< per pixel, 0: masked out; empty: all count

  /// Per pixel, 0..1, over a background.
  std::vector<glm::vec3> over(const glm::vec3& background) const {
    std::vector<glm::vec3> pixels(rgb.size() / 3);
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = photograph_color(&rgb[3 * i]);
    for (std::size_t i = 0; i < alpha.size(); ++i)
      pixels[i] += background_behind(alpha[i], background);
    return pixels;
  }
};

}  // namespace qs::train
