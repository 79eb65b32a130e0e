// SPDX-License-Identifier: MIT
//
// The loss of learn/gradient/loss.h on the GPU, with its gradient, and photographs with 8 bits per
// channel in the memory of the GPU. Gradients equal the CPU's to the bit; the sums of the loss are
// in another, fixed order.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "learn/gradient/loss.h"
#include "learn/step/photograph.h"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::train {

struct LossSums {
  double l1, ssim, squared_error;
};

/// Memory of compare() that the next step uses again.
struct LossScratch {
  DeviceBuffer<float> derivatives;  ///< derivatives of SSIM, 3 fields
  DeviceBuffer<LossSums> of_blocks, of_image;
  unsigned blocks = 0;  ///< blocks of the last comparison
};

/// A loss that is being copied to the host.
class LossCopy {
 public:
  /// Adds up the sums of the last comparison, of `values` values that are not masked, and copies
  /// the result, in `stream`. The previous copy must have arrived.
  void begin(LossScratch& scratch, double values, cudaStream_t stream);
  /// Waits for the copy.
  Loss wait();

 private:
  PinnedValue<LossSums> sums_;
  double values_ = 0;
  Event arrived_;
};

/// A picture and the one to compare it with, per pixel, row by row, in GPU memory.
struct Comparison {
  int width, height;
  const glm::vec3 *color, *target;
  const std::uint8_t* mask;  ///< 0: masked out; null: all count
  std::size_t counted;       ///< pixels that are not masked
};

/// Compares `color` with `target`, and sets `d_color` to the derivatives of the total by `color`.
/// LossCopy reads the loss itself, which the backward pass does not need. Does not wait. Throws
/// Error(device) if memory is short.
void compare(const Comparison& pictures, cudaStream_t stream, LossScratch& scratch,
             DeviceBuffer<glm::vec3>& d_color);

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
