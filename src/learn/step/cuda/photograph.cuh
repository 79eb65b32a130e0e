// SPDX-License-Identifier: MIT
//
// Photographs in the memory of the GPU, with 8 bits per channel.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "learn/step/photograph.h"
#include "raster/cuda/common/device_buffer.cuh"

namespace qs::cuda::train {

struct DevicePhotograph {
  DeviceBuffer<std::uint8_t> rgb;    ///< row by row; over black if there is alpha
  DeviceBuffer<std::uint8_t> alpha;  ///< per pixel, if has_alpha
  DeviceBuffer<std::uint8_t> mask;   ///< per pixel, if has_mask
  std::size_t pixels = 0;            ///< 0: nothing was uploaded
  std::size_t counted = 0;           ///< pixels that are not masked
  bool has_alpha = false, has_mask = false;

  static std::uint64_t bytes_of(const qs::train::Photograph& host) {
    return host.rgb.size() + host.alpha.size() + host.mask.size();
  }

  /// Waits. Throws Error(device).
  void upload(const qs::train::Photograph& host, cudaStream_t stream);

  /// Sets `target` to the colours over a background, per pixel.
  void over(const glm::vec3& background, cudaStream_t stream,
            DeviceBuffer<glm::vec3>& target) const;
};

}  // namespace qs::cuda::train
