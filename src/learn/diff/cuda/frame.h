// SPDX-License-Identifier: MIT
//
// A frame of the differentiable rasterizer on the GPU, in three blocks of device memory that the
// caller owns: of its Gaussians, its pairs and its pixels. project(), list() and blend() fill one
// block each. The backward passes only read them, so any number of frames may wait, and a pass may
// run again. A block may be copied to another place. Blocks begin at multiples of 16 bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "base/error.h"
#include "learn/diff/gaussians.h"
#include "learn/gradient/pixel.h"
#include "raster/scene/camera.h"

namespace qs::cuda::diff {

using namespace qs::diff;

/// The sizes of a frame. The sizes of its blocks follow from them.
struct GpuHeldSizes {
  std::uint32_t gaussians = 0;
  std::uint32_t pairs = 0;  ///< pairs of a tile and a Gaussian; 0 before project()
  std::int32_t width = 0, height = 0;
  std::uint32_t channels = 0;  ///< channels of the blended colours; 0 before blend()
  bool has_depth = false;      ///< blend() sums depths
  bool has_states = false;     ///< blend() keeps states of pixels, see color_blend.cuh

  static GpuHeldSizes of(const Camera& camera, std::size_t gaussians) {
    return {.gaussians = static_cast<std::uint32_t>(gaussians),
            .width = camera.width,
            .height = camera.height};
  }
  /// The sizes of the frame after blend(). Colours of three channels, which faster kernels blend,
  /// have states.
  GpuHeldSizes blended(int channel_count, bool with_depth) const {
    GpuHeldSizes sizes = *this;
    sizes.channels = static_cast<std::uint32_t>(channel_count);
    sizes.has_depth = with_depth;
    sizes.has_states = channel_count == 3;
    return sizes;
  }
  std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  bool operator==(const GpuHeldSizes&) const = default;
};

struct Frame {
  GpuHeldSizes sizes;
  void* gaussians = nullptr;  ///< bytes_of_gaussians()
  void* pairs = nullptr;      ///< bytes_of_pairs()
  void* pixels = nullptr;     ///< bytes_of_pixels()
};

// Bytes of a frame's blocks. The block of pairs depends on their number; the block of pixels
// requires the sizes of GpuHeldSizes::blended().
std::size_t bytes_of_gaussians(const GpuHeldSizes& sizes);
std::size_t bytes_of_pairs(const GpuHeldSizes& sizes);
std::size_t bytes_of_pixels(const GpuHeldSizes& sizes);

/// Per Gaussian, in device memory.
struct GaussianSums {
  const PixelSums<float>* pixels;
  /// Sums of the weight times the derivatives by the sums of z and of 1 / z; null without depths.
  const glm::vec2* depths;
};

/// The stream in which a pass is enqueued, and its end.
struct Queue {
  void* stream = nullptr;  ///< a cudaStream_t of the current device
  std::stop_token stop = {};

  /// Called between passes. Work that was already enqueued still completes.
  void throw_if_cancelled() const {
    if (stop.stop_requested()) throw Cancelled{};
  }
};

/// Host copies of the lists.
struct ListCopies {
  std::vector<std::uint32_t> begin;        ///< per tile and behind the last tile
  std::vector<std::uint32_t> gaussians;    ///< the lists of all tiles, front to back
  std::vector<std::uint32_t> tile_counts;  ///< per Gaussian
  std::vector<std::uint8_t> projected;     ///< per Gaussian: 1 if it has a row in Boundary
};

/// Waits.
ListCopies copy_lists(const Frame& frame, const Queue& queue);

}  // namespace qs::cuda::diff
