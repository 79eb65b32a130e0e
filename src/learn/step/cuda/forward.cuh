// SPDX-License-Identifier: MIT
//
// The forward pass of training: projects the parameters, lists them by tiles, sorts the list of
// every tile by depth, and composites as the CPU's training does. It also stores the values of
// every pixel that the backward pass needs, see learn/diff/cuda/color_blend.cuh. Sums are in the
// same order as on the CPU; alphas differ by rounding.
#pragma once

#include <stop_token>

#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/step/cuda/parameters.cuh"
#include "raster/api/renderer.h"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::train {

/// The view of one training step.
struct StepView {
  const Camera& camera;
  /// mode, sh_degree, background, antialiased (unset = no) and dilation are used.
  const RenderSettings& settings;
  cudaStream_t stream;
  std::stop_token stop = {};

  TileGrid grid() const { return TileGrid::of_image(camera.width, camera.height); }
  bool antialiased() const { return settings.antialiased.value_or(false); }
  std::size_t pixels() const {
    return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  }

  /// Called between passes. Work that was already enqueued still completes.
  void throw_if_cancelled() const {
    if (stop.stop_requested()) throw Cancelled{};
  }
};

using diff::first_segment;
using diff::kNoTile;
using diff::kSegment;
using diff::kTilePixels;
using diff::ListedSplat;
using diff::TilesView;

struct ForwardFrame {
  /// The blocks of Gaussians and pairs. They have room for sizes.gaussians and sizes.pairs.
  /// `projected` is 1 for the Gaussians in the view, see the CPU's Gradients::visible.
  diff::ListedFrame listed{};
  diff::GpuPixelBlock pixels{};
  FootprintArrays footprints{};
  std::uint32_t pairs = 0;     ///< of tiles and Gaussians
  std::uint32_t segments = 0;  ///< of the lists of all tiles

  PinnedValue<unsigned long long> total;  ///< the number of pairs, copied to the host
  Event total_arrived;

  /// Memory that the next step uses again.
  DeviceBuffer<std::byte> of_gaussians, of_footprints, of_pairs, of_lists, of_pixels;
};

// The steps of the pass, in this order. They throw Error(device) if memory is short.

/// Does not read colours. Throws Cancelled.
void project_view(const StepView& view, const ParametersView& parameters, ForwardFrame& frame);

/// Sets the colours of the projected Gaussians, in `stream`, which may run beside list_view().
void color_view(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
                cudaStream_t stream);

/// Fills frame.listed.pairs for `count` projected Gaussians. The host waits for the number
/// of pairs, while the GPU lists: it lists again if the memory was too small for the pairs. Throws
/// Cancelled, and Error(device) if memory is short.
void list_view(const StepView& view, std::uint32_t count, ForwardFrame& frame);

/// Composites the lists.
void draw_view(const StepView& view, ForwardFrame& frame);

}  // namespace qs::cuda::train
