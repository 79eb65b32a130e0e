// SPDX-License-Identifier: MIT
//
// The passes of training. The forward pass projects the parameters, lists them by tiles, sorts the
// list of every tile by depth, and composites as the CPU's training does. It also stores the values
// of every pixel that the backward pass needs, see learn/diff/cuda/color_blend.cuh. Sums are in the
// same order as on the CPU; alphas differ by rounding.
//
// The backward pass goes from the loss's derivatives by the pixels to its derivatives by all
// parameters. Every pair of a tile and a Gaussian gets its own sum over the tile's pixels, and a
// Gaussian's pairs are summed in the order of tiles, as on the CPU. No sum depends on the order in
// which threads run, so two runs give the same bits. learn/diff/cuda/color_sums.cuh computes the
// sums.
#pragma once

#include <stop_token>

#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/gradient/pixel.h"
#include "learn/step/cuda/parameters.cuh"
#include "learn/step/model_state.h"
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

/// Memory of backward() that the next step uses again.
struct BackwardScratch {
  DeviceBuffer<PixelSums<float>> pairs;  ///< per place, see ForwardFrame::pairs
  DeviceBuffer<glm::vec2> absolute;      ///< absolute gradients per pair, if asked for
  DeviceBuffer<PixelSums<float>> sums;   ///< per Gaussian
};

/// `frame` is the result of forward() for the same arguments; `d_color` is per pixel, row by row.
/// With `d_outputs`, which has room for all Gaussians, a colour field computed the colours: they
/// become the derivatives by the outputs of its network, and the coefficients of colour have no
/// derivatives. Does not wait. Throws Cancelled, and Error(device) if memory is short.
void backward(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
              const glm::vec3* d_color, const qs::train::BackwardOrder& order,
              BackwardScratch& scratch, Gradients& gradients, glm::vec3* d_outputs = nullptr);

/// Sets gradients.by.sh, for tests, of a model with coefficients up to `sh_degree`.
void expand_colors(int sh_degree, cudaStream_t stream, Gradients& gradients);

}  // namespace qs::cuda::train
