// SPDX-License-Identifier: MIT
//
// The colours of a photograph that is stored with 8 bits per channel, as training compares them.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "raster/kernel/hd.h"

namespace qs {

/// RGB, 0..1. `rgb` points to three values.
QS_HD glm::vec3 photograph_color(const std::uint8_t* rgb) {
  return {static_cast<float>(rgb[0]) / 255, static_cast<float>(rgb[1]) / 255,
          static_cast<float>(rgb[2]) / 255};
}

/// The background's share of a pixel with this alpha. Photographs with alpha are stored over black,
/// and this is added.
QS_HD glm::vec3 background_behind(std::uint8_t alpha, const glm::vec3& background) {
  return background * (1 - static_cast<float>(alpha) / 255);
}

}  // namespace qs
