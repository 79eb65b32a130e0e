// SPDX-License-Identifier: MIT
#include <algorithm>

#include <glm/geometric.hpp>

#include "raster/cuda/dynamic_shared.cuh"
#include "raster/cuda/train/field.cuh"
#include "raster/cuda/train/field_network.cuh"
#include "raster/cuda/warp.cuh"
#include "raster/kernel/adam.h"
#include "raster/kernel/color_field.h"
#include "raster/kernel/gradient/color_field.h"
#include "raster/kernel/gradient/sh.h"
#include "raster/kernel/integer_sum.h"

namespace qs::cuda::train {
namespace {

constexpr unsigned kCornerThreads = 4;  // of a Gaussian and a level in scatter_gradients()

struct Visible {
  const std::uint32_t* tile_counts;
  __device__ bool operator()(std::uint32_t i) const { return tile_counts[i] > 0; }
};
struct HasGradient {
  const glm::vec3* d_outputs;
  __device__ bool operator()(std::uint32_t i) const { return d_outputs[i] != glm::vec3(0.0f); }
};

/// Lists the Gaussians with has(i). One block per list.
template <class Has>
__global__ void __launch_bounds__(kThreads)
    list_field_gaussians(FieldListsView out, std::uint32_t count, Has has) {
  std::uint32_t* const list = out.gaussians + std::size_t{blockIdx.x} * out.block_size;
  std::uint32_t size = 0;
  for (std::uint32_t first = 0; first < out.block_size; first += kThreads) {
    const std::uint32_t position = first + threadIdx.x;
    const std::size_t i =
        position < out.block_size ? field_gaussian(blockIdx.x, position) : std::size_t{count};
    const bool listed = i < count && has(static_cast<std::uint32_t>(i));
    const auto sum = sum_of_block<kThreads>(listed ? 1u : 0u);
    if (listed) list[size + sum.before] = static_cast<std::uint32_t>(i);
    size += sum.total;
  }
  if (threadIdx.x == 0) out.sizes[blockIdx.x] = size;
}

struct FieldInput {
  FieldView field;
  FieldListsView lists;
  const glm::vec3* means;
  glm::vec3 eye;
  float* features;  ///< see DeviceField
  std::uint32_t row;
  glm::vec3* positions;

  __device__ glm::vec3 direction(std::uint32_t i) const { return glm::normalize(means[i] - eye); }
  __device__ float& feature(unsigned k, std::uint32_t i) const {
    return features[std::size_t{k} * row + i];
  }
  /// False if there is no entry `at` of all lists, one after the other with their room.
  __device__ bool find(std::uint32_t at, std::uint32_t& gaussian) const {
    const std::uint32_t block = at / lists.block_size;
    if (block >= kFieldBlocks || at % lists.block_size >= lists.sizes[block]) return false;
    gaussian = lists.gaussians[at];
    return true;
  }
};

/// One thread per listed Gaussian and level, level after level.
__global__ void __launch_bounds__(kThreads) gather_levels(FieldInput in, unsigned blocks_of_level) {
  const unsigned number = blockIdx.x / blocks_of_level;
  std::uint32_t i = 0;
  if (!in.find(blockIdx.x % blocks_of_level * kThreads + threadIdx.x, i)) return;
  const glm::vec3 position = contract(in.means[i]);
  if (number == 0) in.positions[i] = position;
  const float2* const entries = reinterpret_cast<const float2*>(in.field.grid);
  float2 sums{0.0f, 0.0f};
  for_each_vertex(in.field.levels[number], position, [&](std::size_t entry, float weight) {
    const float2 values = entries[entry];
    sums.x += weight * values.x;
    sums.y += weight * values.y;
  });
  in.feature(kGridFeatures * number, i) = sums.x;
  in.feature(kGridFeatures * number + 1, i) = sums.y;
}

/// All threads of the block call it; a barrier must follow. The inputs of a thread without Gaussian
/// are finite.
__device__ void load_inputs(const FieldInput& in, const TileThread& own, Layer& x) {
  const unsigned grid_inputs = in.field.grid_inputs();
  for (unsigned k = own.part; k < grid_inputs; k += kTileParts)
    x.values[k][own.column] = own.exists ? in.feature(k, own.gaussian) : 0.0f;
  if (own.part > 0) return;
  float basis[kDirectionFeatures] = {};
  if (own.exists) encode_direction(in.direction(own.gaussian), basis);
#pragma unroll
  for (unsigned k = 0; k < kDirectionFeatures; ++k)
    x.values[grid_inputs + k][own.column] = basis[k];
  for (unsigned k = grid_inputs + kDirectionFeatures; k < in.field.inputs; ++k)
    x.values[k][own.column] = 1.0f;
}

struct ForwardTile {
  NetworkWeights weights;
  Layer x, y;
};

/// One block per list.
__global__ void __launch_bounds__(kThreads, 2) color_tiles(FieldInput in, ListedSplat* splats) {
  auto& shared = *static_cast<ForwardTile*>(dynamic_shared());
  const unsigned inputs = in.field.inputs, width = in.field.width;
  const std::uint32_t block = blockIdx.x, size = in.lists.sizes[block];
  if (size == 0) return;
  shared.weights.load(in.field);
  for (std::uint32_t first = 0; first < size; first += kFieldTile) {
    const TileThread own(in.lists, block, first);
    load_inputs(in, own, shared.x);
    __syncthreads();
    hidden_layer(shared.weights.first, inputs, width, own, shared.x, shared.y);
    __syncthreads();
    hidden_layer(shared.weights.second, width, width, own, shared.y, shared.x);
    __syncthreads();
    if (own.exists && own.part < kUsedOutputs) {
      splats[own.gaussian].splat.color[static_cast<int>(own.part)] =
          color_of_output(output_of(shared.weights, own.part, width, own.column, shared.x));
    }
    __syncthreads();  // the next tile overwrites x
  }
}

struct BackwardTile {
  NetworkWeights weights;
  Layer x, first, second;
  float d_output[kUsedOutputs][kTileStride];

  /// Derivatives by the second hidden layer replace its values, which only this thread reads here.
  __device__ void replace_second(const TileThread& own, unsigned width) {
    const unsigned rows = width / kTileParts;
    float by[kUsedOutputs];
#pragma unroll
    for (unsigned output = 0; output < kUsedOutputs; ++output)
      by[output] = d_output[output][own.column];
    for (unsigned row = own.part * rows; row < (own.part + 1) * rows; ++row) {
      float sum = 0;
#pragma unroll
      for (unsigned output = 0; output < kUsedOutputs; ++output)
        sum = fmaf(weights.third[output][row], by[output], sum);
      float& value = second.values[row][own.column];
      value = value > 0.0f ? sum : 0.0f;
    }
  }
};

struct NetworkOutput {
  float* block_weights;
  std::size_t weight_count;
  glm::vec3* d_means;  ///< the derivatives by the directions are added
};

/// One block per list. Computes the hidden layers again.
__global__ void __launch_bounds__(kThreads, 2)
    backward_tiles(FieldInput in, const glm::vec3* d_outputs, NetworkOutput out) {
  auto& shared = *static_cast<BackwardTile*>(dynamic_shared());
  const unsigned inputs = in.field.inputs, width = in.field.width;
  const unsigned grid_inputs = in.field.grid_inputs();
  const std::uint32_t block = blockIdx.x, size = in.lists.sizes[block];
  if (size == 0) return;
  shared.weights.load(in.field);
  WeightSums by_first, by_second;
  const bool sums_third = threadIdx.x < kUsedOutputs * width;
  const unsigned third_row = threadIdx.x / width, third_column = threadIdx.x % width;
  float by_third = 0;
  for (std::uint32_t first = 0; first < size; first += kFieldTile) {
    const TileThread own(in.lists, block, first);
    load_inputs(in, own, shared.x);
    if (own.part < kUsedOutputs) {
      shared.d_output[own.part][own.column] =
          own.exists ? d_outputs[own.gaussian][static_cast<int>(own.part)] : 0.0f;
    }
    __syncthreads();
    hidden_layer(shared.weights.first, inputs, width, own, shared.x, shared.first);
    __syncthreads();
    hidden_layer(shared.weights.second, width, width, own, shared.first, shared.second);
    __syncthreads();
    if (sums_third) {
      for (unsigned begin = 0; begin < kFieldTile; begin += 4) {
        by_third = add_four(four_of(&shared.d_output[third_row][begin]),
                            &shared.second.values[third_column][begin], by_third);
      }
    }
    __syncthreads();
    shared.replace_second(own, width);
    __syncthreads();
    by_second.add(shared.second, width, shared.first, width);
    float by[kChunk];
    through_layer(shared.weights.second, width, width, own, shared.second, by);
    __syncthreads();
    const unsigned rows = width / kTileParts;
#pragma unroll
    for (unsigned k = 0; k < kChunk; ++k) {
      if (k >= rows) break;
      float& value = shared.first.values[own.part * rows + k][own.column];
      value = value > 0.0f ? by[k] : 0.0f;
    }
    __syncthreads();
    by_first.add(shared.first, width, shared.x, inputs);
    through_layer(shared.weights.first, width, inputs, own, shared.first, by);
    __syncthreads();
    const unsigned own_inputs = inputs / kTileParts;
#pragma unroll
    for (unsigned k = 0; k < kChunk; ++k) {
      if (k < own_inputs) shared.x.values[own.part * own_inputs + k][own.column] = by[k];
    }
    __syncthreads();
    if (own.exists) {
      for (unsigned k = own.part; k < grid_inputs; k += kTileParts)
        in.feature(k, own.gaussian) = shared.x.values[k][own.column];
    }
    if (own.exists && own.part == 0) {
      float by_basis[kDirectionFeatures];
#pragma unroll
      for (unsigned k = 0; k < kDirectionFeatures; ++k)
        by_basis[k] = shared.x.values[grid_inputs + k][own.column];
      const glm::vec3 offset = in.means[own.gaussian] - in.eye;
      out.d_means[own.gaussian] += direction_gradient(
          offset, direction_features_gradient(in.direction(own.gaussian), by_basis));
    }
    __syncthreads();  // the next tile overwrites x
  }
  float* const own_weights = out.block_weights + block * out.weight_count;
  by_first.store(width, inputs, own_weights);
  by_second.store(width, width, own_weights + width * inputs);
  if (sums_third) own_weights[width * inputs + width * width + threadIdx.x] = by_third;
}

/// Adds up the blocks in their order. One thread per weight. The weights of unused outputs
/// have no derivative.
__global__ void __launch_bounds__(kThreads)
    sum_field_blocks(FieldListsView lists, const float* block_weights, std::uint32_t weight_count,
                     std::uint32_t used, float* by_weights) {
  const std::uint32_t at = blockIdx.x * kThreads + threadIdx.x;
  if (at >= weight_count) return;
  float sum = 0;
  for (std::uint32_t block = 0; at < used && block < kFieldBlocks; ++block) {
    if (lists.sizes[block] > 0) sum += block_weights[std::size_t{block} * weight_count + at];
  }
  by_weights[at] = sum;
}

/// kCornerThreads threads per listed Gaussian and level, level after level: two features of two
/// neighbouring corners, which often lie in the same sector of memory. A thread takes the four
/// corners on its side.
__global__ void __launch_bounds__(kThreads)
    scatter_gradients(FieldInput in, unsigned blocks_of_level, unsigned long long* sums) {
  const unsigned number = blockIdx.x / blocks_of_level;
  const std::uint32_t thread = blockIdx.x % blocks_of_level * kThreads + threadIdx.x;
  std::uint32_t i = 0;
  if (!in.find(thread / kCornerThreads, i)) return;
  const unsigned feature = thread % kGridFeatures, side = thread / kGridFeatures % 2;
  const float by = in.feature(kGridFeatures * number + feature, i);
  const GridLevel& level = in.field.levels[number];
  const auto cell = GridCell<float>::of(level, in.positions[i]);
#pragma unroll
  for (unsigned upper = 0; upper < 4; ++upper) {
    const unsigned corner = side | upper << 1;
    const std::int64_t units = sum_units(cell.weight(corner) * by);
    if (units == 0) continue;
    atomicAdd(&sums[kGridFeatures * cell.entry(level, corner) + feature],
              static_cast<unsigned long long>(units));
  }
}

struct alignas(16) TwoSums {
  unsigned long long values[2];
};

struct FieldStepInput {
  AdamStep step;
  float rate;
  std::uint32_t grid_count, count;  ///< values; multiples of 4
  float *values, *first, *second;
  unsigned long long* grid_sums;  ///< become 0
  const float* by_weights;
};

/// One thread per four values. A value that never had a gradient stays as it is, and is not read.
__global__ void __launch_bounds__(kThreads) step_field(FieldStepInput in) {
  const std::uint32_t at = 4 * (blockIdx.x * kThreads + threadIdx.x);
  if (at >= in.count) return;
  float4 first = *reinterpret_cast<const float4*>(in.first + at);
  float4 second = *reinterpret_cast<const float4*>(in.second + at);
  float4 by;
  if (at < in.grid_count) {
    auto* const sums = reinterpret_cast<TwoSums*>(in.grid_sums + at);
    const TwoSums low = sums[0], high = sums[1];
    const auto derivative = [](unsigned long long sum) {
      return static_cast<float>(static_cast<double>(static_cast<long long>(sum)) * kSumUnit);
    };
    by = {derivative(low.values[0]), derivative(low.values[1]), derivative(high.values[0]),
          derivative(high.values[1])};
    if ((low.values[0] | low.values[1]) != 0) sums[0] = TwoSums{{0, 0}};
    if ((high.values[0] | high.values[1]) != 0) sums[1] = TwoSums{{0, 0}};
  } else {
    by = *reinterpret_cast<const float4*>(in.by_weights + (at - in.grid_count));
  }
  const auto is_zero = [](const float4& four) {
    return four.x == 0 && four.y == 0 && four.z == 0 && four.w == 0;
  };
  if (is_zero(by) && is_zero(first) && is_zero(second)) return;
  float4 value = *reinterpret_cast<const float4*>(in.values + at);
  adam(in.step, in.rate, by.x, value.x, first.x, second.x);
  adam(in.step, in.rate, by.y, value.y, first.y, second.y);
  adam(in.step, in.rate, by.z, value.z, first.z, second.z);
  adam(in.step, in.rate, by.w, value.w, first.w, second.w);
  *reinterpret_cast<float4*>(in.values + at) = value;
  *reinterpret_cast<float4*>(in.first + at) = first;
  *reinterpret_cast<float4*>(in.second + at) = second;
}

FieldInput input_of(const StepView& view, const ParametersView& parameters, DeviceField& field) {
  return {field.view(),          field.lists(parameters.count),
          parameters.means,      make_view<float>(view.camera).position,
          field.features.data(), sh_row(parameters.count),
          field.positions.data()};
}

}  // namespace

void require_small_network(const ColorField& field) {
  const NetworkShape network = field.network();
  if (network.inputs() <= kMostFieldInputs && network.width <= kMostFieldWidth) return;
  throw Error(ErrorKind::device, "cuda: the network of the colour field has " +
                                     std::to_string(network.inputs()) + " inputs and a width of " +
                                     std::to_string(network.width) +
                                     ", at most 64 of each can be trained");
}

void DeviceField::upload(const qs::train::FieldState& host, cudaStream_t stream) {
  constexpr const char* kWhat = "the colour field";
  shape = {};
  shape.grid = host.field.grid;
  shape.width = host.field.width;
  grid_count = weight_count = 0;  // does not exist if memory is short
  steps = host.steps;
  if (!host.exists()) return;
  require_small_network(shape);
  const std::size_t in_grid = host.field.grid_values.size(), weights = host.field.weights.size();
  const std::size_t count = in_grid + weights;
  values.reserve(kWhat, count);
  grid_sums.reserve(kWhat, in_grid);
  block_weights.reserve(kWhat, kFieldBlocks * weights);
  by_weights.reserve(kWhat, weights);
  list_sizes.reserve(kWhat, kFieldBlocks);
  const auto copy = [&](const std::vector<float>& from, float* to) {
    check(cudaMemcpyAsync(to, from.data(), from.size() * sizeof(float), cudaMemcpyHostToDevice,
                          stream),
          "copy to the GPU");
  };
  copy(host.field.grid_values, values.data());
  copy(host.field.weights, values.data() + in_grid);
  copy_to_device(host.first.data(), first, count, stream);
  copy_to_device(host.second.data(), second, count, stream);
  has_grid_sums = true;  // undefined values
  grid_count = in_grid;
  weight_count = weights;
}

void DeviceField::download(cudaStream_t stream, qs::train::FieldState& host) const {
  host.field = shape;
  host.steps = steps;
  copy_to_host(values.data(), host.field.grid_values, grid_count, stream);
  copy_to_host(values.data() + grid_count, host.field.weights, weight_count, stream);
  const std::size_t count = grid_count + weight_count;
  copy_to_host(first.data(), host.first, count, stream);
  copy_to_host(second.data(), host.second, count, stream);
}

void DeviceField::reserve(std::uint32_t gaussians) {
  constexpr const char* kWhat = "the colours of the step";
  const std::size_t room = with_room(gaussians);
  const auto inputs = static_cast<std::size_t>(shape.network().grid_inputs);
  features.reserve(kWhat, inputs * sh_row(static_cast<std::uint32_t>(room)));
  positions.reserve(kWhat, room);
  d_outputs.reserve(kWhat, room);
  listed.reserve(kWhat, kFieldBlocks * field_block_size(room));
}

FieldView DeviceField::view() const {
  FieldView view{};
  const std::vector<GridLevel> levels = grid_levels(shape.grid);
  std::copy(levels.begin(), levels.end(), view.levels);
  view.level_count = static_cast<unsigned>(levels.size());
  view.inputs = static_cast<unsigned>(shape.network().inputs());
  view.width = static_cast<unsigned>(shape.width);
  view.grid = values.data();
  view.weights = values.data() + grid_count;
  return view;
}

FieldListsView DeviceField::lists(std::uint32_t gaussians) {
  return {listed.data(), list_sizes.data(),
          static_cast<std::uint32_t>(field_block_size(gaussians))};
}

void list_visible(const StepView& view, const ParametersView& parameters, const ForwardFrame& frame,
                  DeviceField& field, cudaStream_t stream) {
  const FieldInput in = input_of(view, parameters, field);
  launch("color", list_field_gaussians<Visible>, Blocks(kFieldBlocks), stream, in.lists,
         parameters.count, Visible{frame.tile_counts.data()});
}

void find_features(const StepView& view, const ParametersView& parameters, DeviceField& field,
                   cudaStream_t stream) {
  const FieldInput in = input_of(view, parameters, field);
  const unsigned blocks = blocks_for(std::uint64_t{kFieldBlocks} * in.lists.block_size);
  launch("color", gather_levels, blocks * in.field.level_count, stream, in, blocks);
}

void find_colors(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
                 DeviceField& field, cudaStream_t stream) {
  const FieldInput in = input_of(view, parameters, field);
  launch("color", color_tiles, Blocks(kFieldBlocks, kThreads, sizeof(ForwardTile)), stream, in,
         frame.splats.data());
}

void color_by_field(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
                    DeviceField& field, cudaStream_t stream) {
  field.reserve(parameters.count);
  if (parameters.count == 0) return;
  list_visible(view, parameters, frame, field, stream);
  find_features(view, parameters, field, stream);
  find_colors(view, parameters, frame, field, stream);
}

void list_changing(const StepView& view, const ParametersView& parameters, DeviceField& field,
                   cudaStream_t stream) {
  const FieldInput in = input_of(view, parameters, field);
  launch("field_gradients", list_field_gaussians<HasGradient>, Blocks(kFieldBlocks), stream,
         in.lists, parameters.count, HasGradient{field.d_outputs.data()});
}

void through_network(const StepView& view, const ParametersView& parameters, DeviceField& field,
                     glm::vec3* d_means, cudaStream_t stream) {
  const FieldInput in = input_of(view, parameters, field);
  launch("field_gradients", backward_tiles, Blocks(kFieldBlocks, kThreads, sizeof(BackwardTile)),
         stream, in, field.d_outputs.data(),
         NetworkOutput{field.block_weights.data(), field.weight_count, d_means});
}

void network_gradients(const StepView& view, const ParametersView& parameters, DeviceField& field,
                       glm::vec3* d_means, cudaStream_t stream) {
  if (parameters.count == 0) return;
  list_changing(view, parameters, field, stream);
  through_network(view, parameters, field, d_means, stream);
}

void sum_weight_gradients(const StepView& view, const ParametersView& parameters,
                          DeviceField& field, cudaStream_t stream) {
  const FieldInput in = input_of(view, parameters, field);
  const auto weights = static_cast<std::uint32_t>(field.weight_count);
  const std::size_t used =
      field.shape.network().third() + std::size_t{kUsedOutputs} * in.field.width;
  launch("field_gradients", sum_field_blocks, blocks_for(weights), stream, in.lists,
         field.block_weights.data(), weights, static_cast<std::uint32_t>(used),
         field.by_weights.data());
}

void sum_grid_gradients(const StepView& view, const ParametersView& parameters, DeviceField& field,
                        cudaStream_t stream) {
  const FieldInput in = input_of(view, parameters, field);
  const unsigned blocks =
      blocks_for(std::uint64_t{kCornerThreads} * kFieldBlocks * in.lists.block_size);
  launch("field_gradients", scatter_gradients, blocks * in.field.level_count, stream, in, blocks,
         field.grid_sums.data());
}

void sum_field_gradients(const StepView& view, const ParametersView& parameters, DeviceField& field,
                         cudaStream_t stream) {
  const auto clear = [&](auto& sums, std::size_t count) {
    check(cudaMemsetAsync(sums.data(), 0, count * sizeof(*sums.data()), stream), "field_gradients");
  };
  if (field.has_grid_sums) clear(field.grid_sums, field.grid_count);
  field.has_grid_sums = true;
  if (parameters.count == 0) {
    clear(field.by_weights, field.weight_count);
    return;
  }
  sum_weight_gradients(view, parameters, field, stream);
  sum_grid_gradients(view, parameters, field, stream);
}

void take_field_step(double rate, DeviceField& field, cudaStream_t stream) {
  const std::size_t count = field.grid_count + field.weight_count;
  launch("step_field", step_field, blocks_for(count / 4), stream,
         FieldStepInput{AdamStep::number(++field.steps), static_cast<float>(rate),
                        static_cast<std::uint32_t>(field.grid_count),
                        static_cast<std::uint32_t>(count), field.values.data(), field.first.data(),
                        field.second.data(), field.grid_sums.data(), field.by_weights.data()});
  field.has_grid_sums = false;
}

}  // namespace qs::cuda::train
