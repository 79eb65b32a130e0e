// SPDX-License-Identifier: MIT
//
// The colours of drawings, plots, pages and the viewer. Accents are Okabe and Ito's, which people
// with any colour vision can distinguish. A culling mode has the same colour everywhere. The colour
// maps of heat maps are safe for colour-blind readers too, and their lightness is monotonic, so
// that they can be printed in gray.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include <glm/vec3.hpp>

#include "raster/kernel/cull/mode.h"

namespace qs {

/// The colour 0xRRGGBB as RGB, 0..1.
constexpr glm::vec3 rgb(std::uint32_t hex) {
  return {static_cast<float>(hex >> 16 & 0xff) / 255.0f,
          static_cast<float>(hex >> 8 & 0xff) / 255.0f, static_cast<float>(hex & 0xff) / 255.0f};
}

/// "#0072B2": a colour for gnuplot and CSS.
std::string hex_text(glm::vec3 color);

inline constexpr glm::vec3 kOrange = rgb(0xE69F00), kSkyBlue = rgb(0x56B4E9),
                           kGreen = rgb(0x009E73), kBlue = rgb(0x0072B2),
                           kVermillion = rgb(0xD55E00), kPurple = rgb(0xCC79A7),
                           kRed = rgb(0xD92626), kGray = rgb(0x808080), kLightGray = rgb(0xBBBBBB);

/// Drawings, plots and pages.
namespace on_white {
inline constexpr glm::vec3 kWhite{1.0f}, kInk = rgb(0x1A1C21), kFaint = rgb(0x6B707A),
                                         kPanel = rgb(0xF6F7F8), kLine = rgb(0xD5D7DB);
/// Index = Stage.
inline constexpr glm::vec3 kStages[] = {kBlue, kSkyBlue, kOrange, kVermillion};

/// The colour, darkened for text: its contrast on white is at least 4.5.
glm::vec3 for_text(glm::vec3 color);
glm::vec3 mode_color(CullMode mode);  ///< for_text()
}  // namespace on_white

/// The viewer, and the legend of a heat map.
namespace on_dark {
inline constexpr glm::vec3 kPanel = rgb(0x16171B), kText = rgb(0xE6E8EB), kFaint = rgb(0x999EA6);
/// Index = Stage. Blue is too dark here.
inline constexpr glm::vec3 kStages[] = {kSkyBlue, kOrange, kGreen, kPurple};

/// mode_color() with lighter colours for black and blue, which are too dark here.
glm::vec3 mode_color(CullMode mode);
}  // namespace on_dark

/// A colour on dark panels, and on light panels and pages.
struct Ink {
  glm::vec3 dark, light;
};

/// The colour of the plugin with this number, 0 or more, in plots.
glm::vec3 plugin_color(std::size_t number);

/// Gray for -1, which find_culler() returns for an unknown name.
glm::vec3 mode_color(CullMode mode);

/// The colour maps of counts.
enum class HeatColors { viridis, inferno, gray };

/// Index = HeatColors.
inline constexpr const char* kHeatColors[] = {"viridis", "inferno", "gray"};

/// The look of a heat map over a picture.
struct HeatStyle {
  HeatColors colors = HeatColors::viridis;
  float opacity = 1;  ///< opacity of the map over the picture's own colours, 0 to 1
  bool operator==(const HeatStyle&) const = default;
};

/// From dark violet over blue and green to yellow. `t` is clamped to 0..1.
glm::vec3 viridis(float t);

/// For counts above 0: a colour map without its darkest part. `t` is clamped to 0..1.
glm::vec3 heat(float t, HeatColors colors = HeatColors::viridis);

/// The colour for a count of 0 over a picture of gray `gray`, 0..1: neutral, and darker than the
/// colour of every count.
glm::vec3 heat_of_zero(float gray);

/// The colour of a cell with the picture's own contrast: `detail` is the picture's brightness here
/// minus the mean around, -1 to 1. All colours are lightened or darkened by the same factor.
glm::vec3 with_detail(glm::vec3 color, float detail);

/// For signed values: blue, almost white at 0, orange to brown. `t` is clamped to -1..1.
glm::vec3 diverging(float t);

}  // namespace qs
