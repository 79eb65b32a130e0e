// SPDX-License-Identifier: MIT
#include "app/picture/palette.h"

#include <array>
#include <cstdint>

namespace qs {

std::string mode_color(const std::string& mode) {
  // Index = CullMode: green, black, orange, sky blue, reddish purple, blue, vermillion.
  constexpr std::array kColors = {"#009E73", "#000000", "#E69F00", "#56B4E9",
                                  "#CC79A7", "#0072B2", "#D55E00"};
  const CullMode found = find_culler(mode);
  return found < 0 ? "#999999" : kColors[static_cast<std::size_t>(found) % kColors.size()];
}

glm::vec3 paper::mode_color(CullMode mode) {
  const std::string hex = qs::mode_color(mode_name(mode));
  const auto rgb = static_cast<std::uint32_t>(std::stoul(hex.substr(1), nullptr, 16));
  return glm::vec3(rgb >> 16 & 0xff, rgb >> 8 & 0xff, rgb & 0xff) / 255.0f;
}

}  // namespace qs
