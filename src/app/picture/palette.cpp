// SPDX-License-Identifier: MIT
#include "app/picture/palette.h"

#include <fmt/format.h>

#include "raster/scene/image.h"

namespace qs {

std::string hex_text(glm::vec3 color) {
  return fmt::format("#{:02X}{:02X}{:02X}", to_8bit(color.r), to_8bit(color.g), to_8bit(color.b));
}

glm::vec3 mode_color(CullMode mode) {
  // Index = CullMode. Other papers' modes are paler than ours.
  constexpr glm::vec3 kColors[] = {kGreen,        glm::vec3(0),  kOrange,       kSkyBlue,
                                   kPurple,       kBlue,         kVermillion,   rgb(0x8FC9A0),
                                   rgb(0x8C6D31), rgb(0xA39BD0), rgb(0xC9B458), rgb(0xB5838D)};
  static_assert(std::size(kColors) == kModeCount + 1);
  return mode < 0 ? kGray : kColors[static_cast<std::size_t>(mode)];
}

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
