// SPDX-License-Identifier: MIT
//
// What every pipeline leaves on the device: the frame's picture and maps. Whatever a target wants
// is made from these.
#pragma once

#include "raster/cuda/device_buffer.cuh"
#include "raster/renderer.h"

namespace qs::cuda {

struct Pixels {
  DeviceBuffer<float> color;              ///< height x width x 3
  DeviceBuffer<std::uint32_t> evaluated;  ///< height x width

  /// Room for what `outputs` asks for.
  void reserve(const Camera& camera, const Outputs& outputs) {
    const std::size_t count =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    if (outputs.color) color.reserve("the frame's image", 3 * count);
    if (outputs.evaluated) evaluated.reserve("the frame's evaluated pairs", count);
  }
};

}  // namespace qs::cuda
