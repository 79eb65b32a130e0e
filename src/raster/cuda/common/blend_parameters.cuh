// SPDX-License-Identifier: MIT
//
// The parameters of the blend kernels of both pipelines. Passed by value.
#pragma once

#include "raster/cuda/common/frame_context.cuh"
#include "raster/cuda/common/pixels.cuh"

namespace qs::cuda {

/// `Range` locates a tile's list; `Entry` is the record that a pipeline blends per Gaussian.
template <class Entry>
struct BlendInput {
  const ListRange* ranges;         ///< per tile: its list in `gaussians`
  const std::uint32_t* gaussians;  ///< the lists of all tiles, front to back: indices into `splats`
  const Entry* splats;
  int columns, rows;  ///< columns and rows of the tile grid
  int width, height;  ///< px
  glm::vec3 background;

  static BlendInput of(const FrameContext& frame, const DeviceBuffer<std::uint32_t>& gaussians,
                       const ListRange* ranges, const DeviceBuffer<Entry>& splats) {
    return {ranges,          gaussians.data(),   splats.data(),       frame.grid.columns,
            frame.grid.rows, frame.camera.width, frame.camera.height, frame.settings.background};
  }
};

/// The parts of Pixels that a kernel writes; null: not requested.
struct BlendOutput {
  float* color;
  std::uint32_t* evaluated;
  std::uint8_t* used;

  static BlendOutput of(Pixels& pixels, const Outputs& outputs) {
    return {outputs.color ? pixels.color.data() : nullptr,
            outputs.evaluated ? pixels.evaluated.data() : nullptr,
            outputs.used ? pixels.used.data() : nullptr};
  }
};

}  // namespace qs::cuda
