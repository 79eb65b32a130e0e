// SPDX-License-Identifier: MIT
//
// A frame's image and maps on the device, as both pipelines write them. Every target (host image,
// GL texture) is filled from these.
#pragma once

#include <numeric>
#include <vector>

#include "raster/cuda/stream.cuh"
#include "raster/renderer.h"

namespace qs::cuda {

struct Pixels {
  DeviceBuffer<float> color;              ///< height x width x 3
  DeviceBuffer<std::uint32_t> evaluated;  ///< height x width
  DeviceBuffer<std::uint8_t> used;        ///< per listed pair: 1 = a pixel blended it

  /// Makes room for the image and the map of evaluated pairs, if `outputs` requests them.
  void reserve(const Camera& camera, const Outputs& outputs) {
    const std::size_t count =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    if (outputs.color) color.reserve("the frame's image", 3 * count);
    if (outputs.evaluated) evaluated.reserve("the frame's evaluated pairs", count);
  }

  /// Makes room for the marks of `pairs` pairs, if `outputs` requests them; clear_used() enqueues
  /// their reset.
  void reserve_used(const Outputs& outputs, std::size_t pairs) {
    if (outputs.used) used.reserve("the frame's used pairs", pairs);
  }
  void clear_used(const Outputs& outputs, std::size_t pairs, cudaStream_t stream) {
    if (outputs.used && pairs > 0) check(cudaMemsetAsync(used.data(), 0, pairs, stream), "blend");
  }

  /// Number of marked pairs per tile. The tiles' lists are contiguous.
  std::vector<std::uint32_t> used_per_tile(const std::vector<std::uint32_t>& list_lengths,
                                           cudaStream_t stream) const {
    const std::uint64_t pairs =
        std::accumulate(list_lengths.begin(), list_lengths.end(), std::uint64_t{0});
    const std::vector<std::uint8_t> marks = copied(used.data(), pairs, stream);
    std::vector<std::uint32_t> sums;
    auto mark = marks.begin();
    for (const std::uint32_t length : list_lengths) {
      sums.push_back(std::accumulate(mark, mark + length, std::uint32_t{0}));
      mark += length;
    }
    return sums;
  }
};

}  // namespace qs::cuda
