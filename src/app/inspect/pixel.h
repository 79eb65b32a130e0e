// SPDX-License-Identifier: MIT
//
// A pixel under the magnifier: the Gaussians that it shows, front to back, from the trace of a
// frame. Works on every backend's trace, and on that of mode reference, whose one list holds for
// all of its region.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/renderer.h"

namespace qs {

/// What a Gaussian adds to a pixel.
struct Contribution {
  std::uint32_t gaussian = 0;  ///< index in the cloud
  float depth = 0;             ///< view z
  float alpha = 0;             ///< 1/255 .. 0.99
  float transmittance = 1;     ///< in front of it
  float weight = 0;            ///< alpha times transmittance; 0 of the one that stops the pixel
  glm::vec3 color{0.0f};
};

struct PixelReport {
  glm::ivec2 pixel{0};
  int tile = 0;
  std::uint32_t listed = 0;                 ///< Gaussians in the tile's list
  std::uint32_t evaluated = 0;              ///< of them, up to and including the one that stops
  std::vector<Contribution> contributions;  ///< front to back
  std::optional<Contribution> stopped_by;
  float transmittance = 1;  ///< what the background shows through
  glm::vec3 color{0.0f};
};

/// `pixel` lies inside the frame's image.
PixelReport inspect_pixel(const Frame& frame, glm::ivec2 pixel, glm::vec3 background);

/// Where in the trace's parallel lists a Gaussian is; unset when the frame does not show it.
std::optional<std::size_t> slot_of(const Trace& trace, std::uint32_t gaussian);

/// The trace's slot of every Gaussian of a cloud of `size`; those not visible have 0xffffffff.
std::vector<std::uint32_t> slots_of(const Trace& trace, std::size_t size);

/// The tile's list: indices in the cloud, front to back. A trace of mode reference has one.
std::span<const std::uint32_t> list_of(const Trace& trace, int tile);

}  // namespace qs
