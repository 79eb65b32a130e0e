// SPDX-License-Identifier: MIT
//
// Ways through the trace of a frame: lists, pixels and Gaussians. Works with the traces of all
// backends and of mode reference, which has one list for its whole region.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "raster/api/renderer.h"
#include "raster/kernel/cull/culler.h"

namespace qs {

/// Index of a Gaussian in the trace's parallel lists; unset if it is not visible.
inline std::optional<std::size_t> slot_of(const Trace& trace, std::uint32_t gaussian) {
  const auto at = std::ranges::lower_bound(trace.gaussians, gaussian);
  if (at == trace.gaussians.end() || *at != gaussian) return std::nullopt;
  return static_cast<std::size_t>(at - trace.gaussians.begin());
}

/// slot_of() every Gaussian of a cloud of `size`; 0xffffffff if it is not visible.
inline std::vector<std::uint32_t> slots_of(const Trace& trace, std::size_t size) {
  std::vector<std::uint32_t> slots(size, 0xffffffffu);
  for (std::size_t slot = 0; slot < trace.gaussians.size(); ++slot)
    slots[trace.gaussians[slot]] = static_cast<std::uint32_t>(slot);
  return slots;
}

/// The tile's list: indices in the cloud, front to back. Mode reference has one list for all tiles.
inline std::span<const std::uint32_t> list_of(const Trace& trace, int tile) {
  const std::size_t lists = trace.tile_begin.size() - 1;
  const std::size_t list = lists == 1 ? 0 : static_cast<std::size_t>(tile);
  return std::span(trace.listed)
      .subspan(trace.tile_begin[list], trace.tile_begin[list + 1] - trace.tile_begin[list]);
}

/// The pixels of a tile in an image of `size`.
inline PixelBox pixels_of(const TileGrid& grid, glm::ivec2 size, int tile) {
  const int x = tile % grid.columns * grid.tile_px, y = tile / grid.columns * grid.tile_px;
  return {x, y, std::min(x + grid.tile_px, size.x), std::min(y + grid.tile_px, size.y)};
}

/// Conservative bound of the pixels of the tile in which the Gaussian reaches 1/255.
inline PixelBox reached(const PixelBox& tile, const Footprint& footprint) {
  if (!(footprint.gamma > 0)) return {};
  const glm::vec2 half = extents(footprint).max + 1.0f, mean = footprint.mean_px;
  const auto clamped = [](float value, int low, int high) {
    return low + clamp_to_int(value - static_cast<float>(low), high - low);
  };
  return {clamped(mean.x - half.x, tile.x0, tile.x1), clamped(mean.y - half.y, tile.y0, tile.y1),
          clamped(mean.x + half.x + 1, tile.x0, tile.x1),
          clamped(mean.y + half.y + 1, tile.y0, tile.y1)};
}

/// Calls visit(x, y) for the pixels of the box, row by row.
template <class Visit>
void for_each_pixel(const PixelBox& box, Visit&& visit) {
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) visit(x, y);
}

}  // namespace qs
