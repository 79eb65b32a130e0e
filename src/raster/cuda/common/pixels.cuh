// SPDX-License-Identifier: MIT
//
// A frame's image and maps on the device, as both pipelines write them. Every target (host image,
// GL texture) is filled from them.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "raster/api/renderer.h"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda {

/// The range [begin, end) of a tile's list in the lists of all tiles.
struct ListRange {
  std::uint32_t begin, end;
  QS_HD std::uint32_t size() const { return end - begin; }
};

/// The number of pairs up to the last list.
inline std::size_t end_of(const std::vector<ListRange>& ranges) {
  std::size_t end = 0;
  for (const ListRange& range : ranges) end = std::max<std::size_t>(end, range.end);
  return end;
}

struct Pixels {
  DeviceBuffer<float> color;              ///< height x width x 3
  DeviceBuffer<std::uint32_t> evaluated;  ///< height x width
  DeviceBuffer<std::uint8_t> used;        ///< per listed pair: 1 = a pixel blended it
  DeviceBuffer<float> depth;              ///< alpha, expected and median depth, one after the other

  static std::size_t count_of(const Camera& camera) {
    return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  }

  /// Makes room for the image and the maps of pixels, if `outputs` requests them.
  void reserve(const Camera& camera, const Outputs& outputs) {
    const std::size_t count = count_of(camera);
    if (outputs.color) color.reserve("the frame's image", 3 * count);
    if (outputs.evaluated) evaluated.reserve("the frame's evaluated pairs", count);
    if (outputs.depth) depth.reserve("the frame's depth", 3 * count);
  }

  /// Makes room for the marks of `pairs` pairs, if `outputs` requests them; clear_used() enqueues
  /// their reset.
  void reserve_used(const Outputs& outputs, std::size_t pairs) {
    if (outputs.used) used.reserve("the frame's used pairs", pairs);
  }
  void clear_used(const Outputs& outputs, std::size_t pairs, cudaStream_t stream) {
    if (outputs.used && pairs > 0) set_zero("blend", used.data(), pairs, stream);
  }

  /// Number of marked pairs per tile.
  std::vector<std::uint32_t> used_per_tile(const std::vector<ListRange>& ranges,
                                           cudaStream_t stream) const {
    const std::vector<std::uint8_t> marks = copied(used.data(), end_of(ranges), stream);
    std::vector<std::uint32_t> sums;
    for (const ListRange& range : ranges) {
      sums.push_back(std::accumulate(marks.begin() + range.begin, marks.begin() + range.end,
                                     std::uint32_t{0}));
    }
    return sums;
  }
};

}  // namespace qs::cuda
