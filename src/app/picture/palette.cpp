// SPDX-License-Identifier: MIT
#include "app/picture/palette.h"

#include <fmt/format.h>

#include "raster/scene/image.h"

namespace qs {

std::string hex_text(glm::vec3 color) {
  return fmt::format("#{:02X}{:02X}{:02X}", to_8bit(color.r), to_8bit(color.g), to_8bit(color.b));
}

glm::vec3 mode_color(CullMode mode) { return mode < 0 ? kGray : rgb(row_of(mode).color); }

glm::vec3 plugin_color(std::size_t number) {
  // Colours that no mode has: a dark red, Okabe and Ito's yellow, a brown, grays.
  constexpr glm::vec3 kColors[] = {kRed, rgb(0xF0E442), rgb(0x8C564B), kGray, kLightGray};
  return kColors[number % std::size(kColors)];
}

glm::vec3 on_dark::mode_color(CullMode mode) {
  const glm::vec3 color = qs::mode_color(mode);
  return color == glm::vec3(0) ? kLightGray : color == kBlue ? rgb(0x268CD9) : color;
}

}  // namespace qs
