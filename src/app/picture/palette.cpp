// SPDX-License-Identifier: MIT
#include "app/picture/palette.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "raster/scene/image.h"

namespace qs {
namespace {

// Every eighth of the 256 colours of viridis, by Nathaniel J. Smith, Stefan van der Walt and Eric
// Firing (CC0). Linear interpolation stays within 2/255 of the full table.
constexpr std::array<std::uint32_t, 33> kViridis = {
    0x440154, 0x470d60, 0x48186a, 0x482374, 0x472d7b, 0x453781, 0x424086, 0x3e4989, 0x3b528b,
    0x375b8d, 0x33638d, 0x2f6b8e, 0x2c728e, 0x297a8e, 0x26828e, 0x23898e, 0x21918c, 0x1f978b,
    0x1f9f88, 0x21a685, 0x27ad81, 0x31b57b, 0x3dbc74, 0x4cc26c, 0x5cc863, 0x6ece58, 0x81d34d,
    0x95d840, 0xaadc32, 0xc0df25, 0xd5e21a, 0xeae51a, 0xfde725};

// Every eighth of the 256 colours of inferno, by the same authors (CC0).
constexpr std::array<std::uint32_t, 33> kInferno = {
    0x000004, 0x040312, 0x0b0724, 0x150b37, 0x210c4a, 0x2e0a5a, 0x3c0965, 0x4a0c6b, 0x57106d,
    0x63146e, 0x70196e, 0x7d1e6d, 0x89226a, 0x962766, 0xa32b61, 0xaf315c, 0xbb3755, 0xc63e4d,
    0xd14644, 0xdb4f3b, 0xe35932, 0xeb6528, 0xf1711e, 0xf67f14, 0xf98d0a, 0xfb9c06, 0xfcab0f,
    0xfbba1f, 0xf9ca32, 0xf5d949, 0xf2e865, 0xf3f586, 0xfcffa4};

// People with any colour vision can distinguish blue and orange. Both sides darken equally.
constexpr std::array<std::uint32_t, 7> kDiverging = {0x0b3c6e, 0x3a7fb8, 0x9cc7e4, 0xf2f2f0,
                                                     0xf4b677, 0xcc6f1d, 0x6e3507};

glm::vec3 unpack(std::uint32_t rgb) {
  return glm::vec3(rgb >> 16 & 0xff, rgb >> 8 & 0xff, rgb & 0xff) / 255.0f;
}

// Interpolates the colours of a table, `t` in 0..1.
template <std::size_t kCount>
glm::vec3 mixed(const std::array<std::uint32_t, kCount>& table, float t) {
  const float at = std::clamp(t, 0.0f, 1.0f) * (kCount - 1);
  const std::size_t left = std::min(static_cast<std::size_t>(at), kCount - 2);
  const float fraction = at - static_cast<float>(left);
  return (1 - fraction) * unpack(table[left]) + fraction * unpack(table[left + 1]);
}

}  // namespace

std::string hex_text(glm::vec3 color) {
  return fmt::format("#{:02X}{:02X}{:02X}", to_8bit(color.r), to_8bit(color.g), to_8bit(color.b));
}

glm::vec3 mode_color(CullMode mode) { return mode < 0 ? kGray : rgb(row_of(mode).color); }

glm::vec3 plugin_color(std::size_t number) {
  // Colours that no mode has: a dark red, Okabe and Ito's yellow, a brown, grays.
  constexpr glm::vec3 kColors[] = {kRed, rgb(0xF0E442), rgb(0x8C564B), kGray, kLightGray};
  return kColors[number % std::size(kColors)];
}

glm::vec3 on_white::mode_color(CullMode mode) { return for_text(qs::mode_color(mode)); }

glm::vec3 on_white::for_text(glm::vec3 color) {
  constexpr glm::vec3 kShares{0.2126f, 0.7152f, 0.0722f};
  constexpr float kMostLuminance = 0.175f;  // white has 1.05 / (0.175 + 0.05) = 4.67 times as much
  while (glm::dot(kShares, glm::pow(color, glm::vec3(2.2f))) > kMostLuminance) color *= 0.98f;
  return color;
}

glm::vec3 on_dark::mode_color(CullMode mode) {
  const glm::vec3 color = qs::mode_color(mode);
  return color == glm::vec3(0) ? kLightGray : color == kBlue ? rgb(0x268CD9) : color;
}

glm::vec3 viridis(float t) { return mixed(kViridis, t); }

glm::vec3 heat(float t, HeatColors colors) {
  const float count = std::clamp(t, 0.0f, 1.0f);
  if (colors == HeatColors::inferno) return mixed(kInferno, 0.3f + 0.7f * count);
  if (colors == HeatColors::gray) return glm::vec3(0.25f + 0.75f * count);
  return viridis(0.2f + 0.8f * count);
}

// shaders/present.frag repeats heat_of_zero() and with_detail().
glm::vec3 heat_of_zero(float gray) { return glm::vec3(0.05f + 0.08f * gray); }

glm::vec3 with_detail(glm::vec3 color, float detail) { return (1 + 0.5f * detail) * color; }

glm::vec3 diverging(float t) { return mixed(kDiverging, 0.5f * (t + 1)); }

}  // namespace qs
