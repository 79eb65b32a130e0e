// SPDX-License-Identifier: MIT
#include "app/picture/palette.h"

#include <cstdint>
#include <string>

#include "app/bench/plot.h"

namespace qs::paper {

glm::vec3 mode_color(CullMode mode) {
  const std::string hex = qs::mode_color(mode_name(mode));
  const auto rgb = static_cast<std::uint32_t>(std::stoul(hex.substr(1), nullptr, 16));
  return glm::vec3(rgb >> 16 & 0xff, rgb >> 8 & 0xff, rgb & 0xff) / 255.0f;
}

}  // namespace qs::paper
