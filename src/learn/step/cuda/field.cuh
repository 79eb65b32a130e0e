// SPDX-License-Identifier: MIT
//
// A colour field in training on the GPU, and its passes. Each level of the hash grid is read and
// written by a launch's blocks one after another, so that the level stays in the L2 cache; its sums
// grow for Gaussians that are neighbours in space one after another. A block computes the network
// for a tile of Gaussians, see field_network.cuh. Sums have the order of the CPU's. The network
// fuses multiplications and additions, so its values differ from the CPU's by rounding.
#pragma once

#include <cstdint>

#include "learn/step/cuda/forward.cuh"
#include "learn/step/model_state.h"
#include "raster/cuda/common/scan_and_sort.cuh"
#include "raster/field/color_field.h"

namespace qs::cuda::train {

/// Inputs and width of the largest network that is trained.
inline constexpr int kMostFieldInputs = 64, kMostFieldWidth = 64;
inline constexpr int kMostFieldLevels = (kMostFieldInputs - kDirectionFeatures) / kGridFeatures;

/// The Gaussians that a pass of the field visits, by the blocks of field_gaussian(). Passed by
/// value.
struct FieldListsView {
  std::uint32_t* gaussians;  ///< (kFieldBlocks, block_size)
  std::uint32_t* sizes;      ///< per block
  std::uint32_t block_size;

  /// Number of Gaussians from entry `at` to the end of its list. Lists lie one after the other with
  /// their room.
  __device__ std::uint32_t listed_from(std::uint32_t at) const {
    const std::uint32_t block = at / block_size, place = at % block_size;
    return block < kFieldBlocks && place < sizes[block] ? sizes[block] - place : 0;
  }
};

/// The Gaussians of a pass in two orders. Only the backward pass has lists in space. Passed by
/// value.
struct FieldLists {
  FieldListsView by_index;
  FieldListsView in_space;  ///< in the order of DeviceField::order, its blocks one after the other
};

/// The parameters of the field as kernels read them. Passed by value.
struct FieldView {
  GridLevel levels[kMostFieldLevels];
  unsigned level_count;
  unsigned inputs, width;  ///< inputs and width of the network
  const float *grid, *weights;

  __device__ unsigned grid_inputs() const { return kGridFeatures * level_count; }
};

struct DeviceField {
  ColorField shape;  ///< without values
  /// Values of the grid, then of the network, and Adam's moments.
  DeviceBuffer<float> values, first, second;
  std::size_t grid_count = 0, weight_count = 0;
  std::uint64_t steps = 0;

  // Per Gaussian.
  /// Row k of sh_row() pairs: the features of level k of the grid, and after the network's backward
  /// pass the derivatives by them. Undefined for Gaussians that are not visible.
  DeviceBuffer<float2> features;
  /// In the grid, of visible Gaussians. A copy, because the sums over the grid run beside the step
  /// of the means.
  DeviceBuffer<glm::vec3> positions;
  DeviceBuffer<glm::vec3> d_outputs;  ///< derivative by the network's outputs; zero if not visible
  DeviceBuffer<std::uint32_t> listed, list_sizes;  ///< the arrays of both FieldLists

  /// All Gaussians (pairs.values) in the order of a curve through space. Neighbours change the
  /// same sums of the grid, so they are added one after the other.
  struct Order {
    SortBuffers pairs;
    std::uint32_t size = 0;
    int age = 0;  ///< iterations
  } order;

  // Derivatives.
  DeviceBuffer<unsigned long long> grid_sums;  ///< in units of kSumUnit
  bool has_grid_sums = false;                  ///< false: all are zero
  DeviceBuffer<float> block_weights;           ///< (kFieldBlocks, weight_count), of listed blocks
  DeviceBuffer<float> by_weights;

  bool exists() const { return weight_count > 0; }

  /// Replaces the field. Throws Error(device), also if the network is too large.
  void upload(const qs::train::FieldState& host, cudaStream_t stream);
  /// Waits.
  void download(cudaStream_t stream, qs::train::FieldState& host) const;
  /// Makes room for the passes of `gaussians`.
  void reserve(std::uint32_t gaussians);
  /// Finds the order again if there is another number of Gaussians, or after many iterations.
  void keep_order(const ParametersView& parameters, cudaStream_t stream);

  FieldView view() const;
  FieldLists lists(std::uint32_t gaussians);
};

/// Throws Error(device) if the field's network is larger than the published ones.
void require_small_network(const ColorField& field);

/// The passes of a field for a view, in a stream.
struct FieldPasses {
  const StepView& view;
  const ParametersView& parameters;
  DeviceField& field;
  cudaStream_t stream;

  /// Sets the colours of the projected Gaussians, in a stream that may run beside list_view().
  void color(ForwardFrame& frame) const;

  /// From field.d_outputs to the derivatives by the weights, block by block, and by the grid's
  /// features. Adds the derivatives by the directions to `d_means`.
  void network_gradients(glm::vec3* d_means) const;

  /// Sums the derivatives by the weights and by the grid's values, after network_gradients().
  void sum_gradients() const;

  // The steps of these passes, for at least one Gaussian; programs that measure call them one by
  // one.
  // Of color():
  void list_visible(const ForwardFrame& frame) const;
  void find_features() const;
  void find_colors(ForwardFrame& frame) const;
  // Of network_gradients():
  void list_changing() const;
  void through_network(glm::vec3* d_means) const;
  // Of sum_gradients():
  void sum_weight_gradients() const;
  void sum_grid_gradients() const;
};

/// One step of Adam for all values, after FieldPasses::sum_gradients().
void take_field_step(double rate, DeviceField& field, cudaStream_t stream);

}  // namespace qs::cuda::train
