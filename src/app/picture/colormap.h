// SPDX-License-Identifier: MIT
//
// Colour maps for heat maps. They are safe for colour-blind readers, and their lightness is
// monotonic, so that they can be printed in gray.
#pragma once

#include <glm/vec3.hpp>

namespace qs {

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
