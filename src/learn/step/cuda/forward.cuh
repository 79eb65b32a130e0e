// SPDX-License-Identifier: MIT
//
// The forward pass of training: projects the parameters, lists them by tiles, sorts the list of
// every tile by depth, and composites as the CPU's training does. It also stores the values of
// every pixel that the backward pass needs, see learn/diff/cuda/color_blend.cuh. Sums are in the
// same order as on the CPU; alphas differ by rounding.
#pragma once

#include <stop_token>

#include "learn/diff/cuda/tiles.cuh"
#include "learn/step/cuda/parameters.cuh"
#include "raster/api/renderer.h"
#include "raster/cuda/common/block_sort.cuh"
#include "raster/cuda/common/footprints.cuh"
#include "raster/cuda/common/schedule.cuh"
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

/// Pairs of a tile and a Gaussian. The pairs of a Gaussian have neighbouring places, in the order
/// of tiles.
struct ListedPairs {
  // Per place.
  DeviceBuffer<std::uint32_t> owners;  ///< its Gaussian
  DeviceBuffer<std::uint32_t> tiles;   ///< its tile, until the lists are sorted
  DeviceBuffer<std::uint32_t> slots;   ///< its index in the tile's list, before that is sorted
  // The lists of all tiles.
  DeviceBuffer<SortEntry> entries;     ///< depths and places, in any order
  DeviceBuffer<std::uint32_t> places;  ///< front to back
  std::uint32_t count = 0;

  /// Pairs that the buffers have room for. It grows in larger steps than the number of pairs.
  std::uint32_t room() const { return static_cast<std::uint32_t>(places.capacity()); }
  void reserve(std::uint32_t pairs);
};

struct TileLists {
  DeviceBuffer<std::uint32_t> sizes;
  DeviceBuffer<uint2> ranges;  ///< per tile: its list is [x, y)
  /// The order in which tiles are composited, see ScheduleView.
  DeviceBuffer<std::uint32_t> class_sizes, scheduled;

  void reserve(unsigned tiles);
  ScheduleView schedule(unsigned tiles) const {
    return {class_sizes.data(), scheduled.data(), tiles};
  }
};

/// The number of pairs, summed on the GPU and copied to the host.
struct PairTotal {
  DeviceBuffer<unsigned long long> sum;
  PinnedValue<unsigned long long> copy;
  Event arrived;
};

struct ForwardFrame {
  // Per Gaussian.
  DeviceBuffer<std::uint32_t> tile_counts;   ///< 0: not visible; the others are undefined
  DeviceBuffer<std::uint32_t> first_places;  ///< the first place of its pairs
  DeviceBuffer<std::uint32_t> depth_keys;    ///< bits of the depth, which is positive
  FootprintBuffers footprints;
  DeviceBuffer<ListedSplat> splats;
  DeviceBuffer<std::uint8_t> in_view;  ///< see the CPU's Gradients::visible

  PairTotal total;
  ListedPairs pairs;
  TileLists lists;

  // Per pixel, row by row.
  DeviceBuffer<glm::vec3> color;      ///< over the background, not clamped
  DeviceBuffer<float> transmittance;  ///< behind the last Gaussian
  DeviceBuffer<std::uint32_t> last;   ///< entries of the tile's list up to the last blended entry

  // Per segment, see BlendTarget.
  DeviceBuffer<std::uint32_t> segment_tiles;
  DeviceBuffer<float4> states;
  std::uint32_t segments = 0;

  TilesView tiles(const StepView& view) const {
    return {lists.ranges.data(), pairs.places.data(), pairs.owners.data(), splats.data(),
            view.grid().columns, view.camera.width,   view.camera.height};
  }
};

// The steps of the pass, in this order. They throw Error(device) if memory is short.

/// Does not read colours. Throws Cancelled.
void project_view(const StepView& view, const ParametersView& parameters, ForwardFrame& frame);

/// Sets the colours of the projected Gaussians, in `stream`, which may run beside list_view().
void color_view(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
                cudaStream_t stream);

/// Fills frame.pairs and frame.lists for `count` projected Gaussians. The host waits for the number
/// of pairs, while the GPU lists: it lists again if the memory was too small for the pairs. Throws
/// Cancelled, and Error(device) if memory is short.
void list_view(const StepView& view, std::uint32_t count, ForwardFrame& frame);

/// Composites the lists.
void draw_view(const StepView& view, ForwardFrame& frame);

}  // namespace qs::cuda::train
