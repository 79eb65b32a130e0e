// SPDX-License-Identifier: MIT
#include <algorithm>

#include <glm/geometric.hpp>

#include "base/morton.h"
#include "learn/gradient/adam.h"
#include "learn/gradient/color_field.h"
#include "learn/gradient/integer_sum.h"
#include "learn/gradient/sh.h"
#include "learn/step/cuda/field.cuh"
#include "learn/step/cuda/field_network.cuh"
#include "raster/cuda/common/dynamic_shared.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/color_field.h"

namespace qs::cuda::train {
namespace {

// A run of neighbouring Gaussians in sum_runs(): threads for two features of eight corners.
constexpr unsigned kRunSize = 32, kRunThreads = 8 * kGridFeatures;
constexpr unsigned kRuns = kThreads / kRunThreads;  // of a block
static_assert(kFieldRun % kRunSize == 0);

// The order in space has the resolution of this many cells along an axis.
constexpr int kOrderBits = 10;
constexpr int kOrderAge = 100;  // iterations, in which the means move a little

struct Visible {
  const std::uint32_t* tile_counts;
  __device__ bool operator()(std::uint32_t i) const { return tile_counts[i] > 0; }
};
struct HasGradient {
  const glm::vec3* d_outputs;
  __device__ bool operator()(std::uint32_t i) const { return d_outputs[i] != glm::vec3(0.0f); }
};

/// Lists the Gaussians with has(i). One block per list: kFieldBlocks lists in the order of the
/// model, then, if the launch has them, as many in the order in space.
template <class Has>
__global__ void __launch_bounds__(kThreads)
    list_field_gaussians(FieldLists lists, const std::uint32_t* in_space, std::uint32_t count,
                         Has has) {
  const bool is_in_space = blockIdx.x >= kFieldBlocks;
  const FieldListsView out = is_in_space ? lists.in_space : lists.by_index;
  const std::uint32_t block = blockIdx.x % kFieldBlocks;
  std::uint32_t* const list = out.gaussians + std::size_t{block} * out.block_size;
  std::uint32_t size = 0;
  for (std::uint32_t first = 0; first < out.block_size; first += kThreads) {
    const std::uint32_t position = first + threadIdx.x;
    std::size_t i = count;
    if (position < out.block_size) {
      i = is_in_space ? std::size_t{block} * out.block_size + position
                      : field_gaussian(block, position);
      if (is_in_space && i < count) i = in_space[i];
    }
    const bool listed = i < count && has(static_cast<std::uint32_t>(i));
    const auto sum = sum_of_block<kThreads>(listed ? 1u : 0u);
    if (listed) list[size + sum.before] = static_cast<std::uint32_t>(i);
    size += sum.total;
  }
  if (threadIdx.x == 0) out.sizes[block] = size;
}

struct FieldInput {
  FieldView field;
  FieldLists lists;
  const glm::vec3* means;
  glm::vec3 eye;
  float2* features;  ///< see DeviceField
  std::uint32_t row;
  glm::vec3* positions;  ///< see DeviceField

  __device__ glm::vec3 direction(std::uint32_t i) const { return glm::normalize(means[i] - eye); }
  __device__ float2& features_of(std::uint32_t i, unsigned level) const {
    return features[std::size_t{level} * row + i];
  }
};

/// One thread per listed Gaussian and level, level after level.
__global__ void __launch_bounds__(kThreads) gather_levels(FieldInput in, unsigned blocks_of_level) {
  const unsigned number = blockIdx.x / blocks_of_level;
  const std::uint32_t at = blockIdx.x % blocks_of_level * kThreads + threadIdx.x;
  if (in.lists.by_index.listed_from(at) == 0) return;
  const std::uint32_t i = in.lists.by_index.gaussians[at];
  const glm::vec3 position = contract(in.means[i]);
  if (number == 0) in.positions[i] = position;
  const float2* const entries = reinterpret_cast<const float2*>(in.field.grid);
  float2 sums{0.0f, 0.0f};
  for_each_vertex(in.field.levels[number], position, [&](std::size_t entry, float weight) {
    const float2 values = entries[entry];
    sums.x += weight * values.x;
    sums.y += weight * values.y;
  });
  in.features_of(i, number) = sums;
}

/// All threads of the block call it; a barrier must follow. The inputs of a thread without Gaussian
/// are finite.
template <unsigned kInputs>
__device__ void load_inputs(const FieldInput& in, const TileThread& own, Layer& x) {
  const unsigned grid_inputs = in.field.grid_inputs();
  for (unsigned level = own.part; level < in.field.level_count; level += kTileParts) {
    const float2 two = own.exists ? in.features_of(own.gaussian, level) : float2{0.0f, 0.0f};
    x.values[kGridFeatures * level][own.column] = two.x;
    x.values[kGridFeatures * level + 1][own.column] = two.y;
  }
  if (own.part > 0) return;
  float basis[kDirectionFeatures] = {};
  if (own.exists) encode_direction(in.direction(own.gaussian), basis);
#pragma unroll
  for (unsigned k = 0; k < kDirectionFeatures; ++k)
    x.values[grid_inputs + k][own.column] = basis[k];
  for (unsigned k = grid_inputs + kDirectionFeatures; k < kInputs; ++k)
    x.values[k][own.column] = k < in.field.inputs ? 1.0f : 0.0f;
}

struct ForwardTile {
  NetworkWeights weights;
  Layer x, y;
};

/// One block per list.
template <unsigned kInputs>
__global__ void __launch_bounds__(kNetworkThreads, 2)
    color_tiles(FieldInput in, ListedSplat* splats) {
  auto& shared = *static_cast<ForwardTile*>(dynamic_shared());
  const std::uint32_t block = blockIdx.x, size = in.lists.by_index.sizes[block];
  if (size == 0) return;
  shared.weights.load(in.field);
  for (std::uint32_t first = 0; first < size; first += kFieldTile) {
    const TileThread own(in.lists.by_index, block, first);
    load_inputs<kInputs>(in, own, shared.x);
    __syncthreads();
    hidden_layer<kInputs>(shared.weights.first, shared.x, shared.y);
    __syncthreads();
    hidden_layer<kMostRows>(shared.weights.second, shared.y, shared.x);
    __syncthreads();
    for (unsigned output = own.part; own.exists && output < kUsedOutputs; output += kTileParts)
      splats[own.gaussian].splat.color[static_cast<int>(output)] =
          color_of_output(output_of(shared.weights, output, own.column, shared.x));
    __syncthreads();  // the next tile overwrites x
  }
}

struct BackwardTile {
  NetworkWeights weights;
  Layer x, first, second;
  float d_output[kUsedOutputs][kRowStride];

  /// Derivatives by the second hidden layer replace its values.
  __device__ void replace_second() {
    const unsigned column = 4 * Patch::column();
    float4 by[kUsedOutputs];
#pragma unroll
    for (unsigned output = 0; output < kUsedOutputs; ++output)
      by[output] = four_of(&d_output[output][column]);
#pragma unroll
    for (unsigned j = 0; j < Patch::kRows; ++j) {
      const unsigned row = Patch::row() + 8 * j;
      Patch sums;
#pragma unroll
      for (unsigned output = 0; output < kUsedOutputs; ++output)
        sums.add(0, weights.third[output][row], by[output]);
      replace_where_positive(&second.values[row][column], sums.four(0));
    }
  }
};

/// One block per list. Computes the hidden layers again. Adds the derivatives by the directions to
/// `d_means`.
template <unsigned kInputs>
__global__ void __launch_bounds__(kNetworkThreads, 2)
    backward_tiles(FieldInput in, const glm::vec3* d_outputs, float* block_weights,
                   std::size_t weight_count, glm::vec3* d_means) {
  auto& shared = *static_cast<BackwardTile*>(dynamic_shared());
  const unsigned inputs = in.field.inputs, width = in.field.width;
  const unsigned grid_inputs = in.field.grid_inputs();
  const std::uint32_t block = blockIdx.x, size = in.lists.by_index.sizes[block];
  if (size == 0) return;
  shared.weights.load(in.field);
  WeightSums<kInputs> by_first;
  WeightSums<kMostRows> by_second;
  LastWeightSums by_third;
  for (std::uint32_t first = 0; first < size; first += kFieldTile) {
    const TileThread own(in.lists.by_index, block, first);
    load_inputs<kInputs>(in, own, shared.x);
    for (unsigned output = own.part; output < kUsedOutputs; output += kTileParts)
      shared.d_output[output][own.column] =
          own.exists ? d_outputs[own.gaussian][static_cast<int>(output)] : 0.0f;
    __syncthreads();
    hidden_layer<kInputs>(shared.weights.first, shared.x, shared.first);
    __syncthreads();
    hidden_layer<kMostRows>(shared.weights.second, shared.first, shared.second);
    __syncthreads();
    by_third.add(shared.d_output, shared.second);
    __syncthreads();
    shared.replace_second();
    __syncthreads();
    by_second.add(shared.second, shared.first);
    {
      const InputDerivatives<kMostRows> by(shared.weights.second, shared.second);
      __syncthreads();
      by.replace_positive(shared.first);
    }
    __syncthreads();
    by_first.add(shared.first, shared.x);
    {
      const InputDerivatives<kInputs> by(shared.weights.first, shared.first);
      __syncthreads();
      by.replace(shared.x);
    }
    __syncthreads();
    if (own.exists) {
      for (unsigned level = own.part; level < in.field.level_count; level += kTileParts)
        in.features_of(own.gaussian, level) = {
            shared.x.values[kGridFeatures * level][own.column],
            shared.x.values[kGridFeatures * level + 1][own.column]};
    }
    if (own.exists && own.part == 0) {
      float by_basis[kDirectionFeatures];
#pragma unroll
      for (unsigned k = 0; k < kDirectionFeatures; ++k)
        by_basis[k] = shared.x.values[grid_inputs + k][own.column];
      const glm::vec3 offset = in.means[own.gaussian] - in.eye;
      d_means[own.gaussian] += direction_gradient(
          offset, direction_features_gradient(in.direction(own.gaussian), by_basis));
    }
    __syncthreads();  // the next tile overwrites x
  }
  float* const own_weights = block_weights + block * weight_count;
  by_first.store(width, inputs, own_weights);
  by_second.store(width, width, own_weights + width * inputs);
  by_third.store(width, own_weights + width * inputs + width * width);
}

/// Adds up the blocks in their order. One thread per weight. The weights of unused outputs
/// have no derivative.
__global__ void __launch_bounds__(kThreads)
    sum_field_blocks(FieldListsView lists, const float* block_weights, std::uint32_t weight_count,
                     std::uint32_t used, float* by_weights) {
  constexpr unsigned kAtOnce = 16;  // reads that wait together
  static_assert(kFieldBlocks % kAtOnce == 0);
  const std::uint32_t at = blockIdx.x * kThreads + threadIdx.x;
  if (at >= weight_count) return;
  float sum = 0;
  for (std::uint32_t first = 0; at < used && first < kFieldBlocks; first += kAtOnce) {
    float values[kAtOnce];
#pragma unroll
    for (unsigned k = 0; k < kAtOnce; ++k)
      values[k] = lists.sizes[first + k] > 0
                      ? block_weights[std::size_t{first + k} * weight_count + at]
                      : 0.0f;
#pragma unroll
    for (unsigned k = 0; k < kAtOnce; ++k) sum += values[k];
  }
  by_weights[at] = sum;
}

/// A Gaussian in a level of the grid, and the derivatives by its features.
struct alignas(16) GridItem {
  GridCell<float> cell;
  float by[kGridFeatures];
};

/// Level after level, kRunThreads threads per run of Gaussians that are neighbours in space. A
/// thread adds up a feature of a corner while the Gaussians stay in a cell. Sums are integers, so
/// the order does not matter. Two neighbouring corners often lie in the same sector of memory.
__global__ void __launch_bounds__(kThreads)
    sum_runs(FieldInput in, unsigned blocks_of_level, unsigned long long* sums) {
  __shared__ GridItem items[kRuns][kRunSize + 1];  // runs begin in different banks
  __shared__ bool leaves[kRuns][kRunSize];         // the next Gaussian is in another cell
  const unsigned number = blockIdx.x / blocks_of_level;
  const GridLevel& level = in.field.levels[number];
  const FieldListsView& lists = in.lists.in_space;
  const std::uint32_t first = blockIdx.x % blocks_of_level * (kRuns * kRunSize);
#pragma unroll
  for (unsigned k = threadIdx.x; k < kRuns * kRunSize; k += kThreads) {
    if (lists.listed_from(first + k) == 0) continue;
    const std::uint32_t i = lists.gaussians[first + k];
    const float2 by = in.features_of(i, number);
    items[k / kRunSize][k % kRunSize] = {GridCell<float>::of(level, in.positions[i]), {by.x, by.y}};
  }
  __syncthreads();
#pragma unroll
  for (unsigned k = threadIdx.x; k < kRuns * kRunSize; k += kThreads) {
    const std::uint32_t listed = lists.listed_from(first + k);
    if (listed == 0) continue;
    const GridItem* const item = &items[k / kRunSize][k % kRunSize];
    const bool is_last = listed == 1 || k % kRunSize == kRunSize - 1;
    leaves[k / kRunSize][k % kRunSize] = is_last || !item[0].cell.is(item[1].cell);
  }
  __syncthreads();
  const unsigned run = threadIdx.x / kRunThreads;
  const unsigned feature = threadIdx.x % kGridFeatures;
  const unsigned corner = threadIdx.x / kGridFeatures % 8;
  const std::uint32_t size = min(lists.listed_from(first + run * kRunSize), kRunSize);
  std::int64_t units = 0;
  for (unsigned k = 0; k < size; ++k) {
    const GridItem& item = items[run][k];
    units += sum_units(item.cell.weight(corner) * item.by[feature]);
    if (!leaves[run][k]) continue;
    if (units != 0)
      atomicAdd(&sums[kGridFeatures * item.cell.entry(level, corner) + feature],
                static_cast<unsigned long long>(units));
    units = 0;
  }
}

struct alignas(16) TwoSums {
  unsigned long long values[2];
};

FieldInput input_of(const FieldPasses& passes) {
  const auto& [view, parameters, field, stream] = passes;
  return {field.view(),          field.lists(parameters.count),
          parameters.means,      make_view<float>(view.camera).position,
          field.features.data(), sh_row(parameters.count),
          field.positions.data()};
}

/// The resolution of the order of the Gaussians.
__device__ std::uint32_t cell_of(float place) {
  constexpr float kCells = 1u << kOrderBits;
  if (!(place > 0)) return 0;  // also if it is not a number
  return place < 1 ? static_cast<std::uint32_t>(place * kCells) : (1u << kOrderBits) - 1;
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
  cuda::copy_to_device(host.field.grid_values.data(), in_grid, values.data(), stream);
  cuda::copy_to_device(host.field.weights.data(), weights, values.data() + in_grid, stream);
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
  features.reserve(kWhat, grid_levels(shape.grid).size() *
                              std::size_t{sh_row(static_cast<std::uint32_t>(room))});
  positions.reserve(kWhat, room);
  d_outputs.reserve(kWhat, room);
  listed.reserve(kWhat, 2 * kFieldBlocks * field_block_size(room));
  list_sizes.reserve(kWhat, std::size_t{2} * kFieldBlocks);
}

void DeviceField::keep_order(const ParametersView& parameters, cudaStream_t stream) {
  if (order.size == parameters.count && ++order.age < kOrderAge) return;
  order.pairs.reserve("the order of the Gaussians in space",
                      static_cast<std::uint32_t>(with_room(parameters.count)));
  for_each_item("color", parameters.count, stream,
                [means = parameters.means, keys = order.pairs.keys.data(),
                 gaussians = order.pairs.values.data()] __device__(std::uint32_t i) {
                  const glm::vec3 place = contract(means[i]);
                  keys[i] = morton_code(cell_of(place.x), cell_of(place.y), cell_of(place.z));
                  gaussians[i] = i;
                });
  sort_pairs(order.pairs, parameters.count, 3 * kOrderBits, stream);
  order.size = parameters.count;
  order.age = 0;
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

FieldLists DeviceField::lists(std::uint32_t gaussians) {
  const auto block_size = static_cast<std::uint32_t>(field_block_size(gaussians));
  return {{listed.data(), list_sizes.data(), block_size},
          {listed.data() + std::size_t{kFieldBlocks} * block_size, list_sizes.data() + kFieldBlocks,
           block_size}};
}

void FieldPasses::list_visible(const ForwardFrame& frame) const {
  launch("color", list_field_gaussians<Visible>, kFieldBlocks, stream, input_of(*this).lists,
         field.order.pairs.values.data(), parameters.count,
         Visible{frame.listed.gaussians.tile_counts});
}

void FieldPasses::find_features() const {
  const FieldInput in = input_of(*this);
  const unsigned blocks = blocks_for(std::uint64_t{kFieldBlocks} * in.lists.by_index.block_size);
  launch("color", gather_levels, blocks * in.field.level_count, stream, in, blocks);
}

void FieldPasses::find_colors(ForwardFrame& frame) const {
  const FieldInput in = input_of(*this);
  const bool is_short = in.field.inputs <= kPublishedInputs;
  launch("color", is_short ? color_tiles<kPublishedInputs> : color_tiles<kMostRows>,
         Blocks(kFieldBlocks, kNetworkThreads, sizeof(ForwardTile)), stream, in,
         frame.listed.gaussians.splats);
}

void FieldPasses::color(ForwardFrame& frame) const {
  field.reserve(parameters.count);
  if (parameters.count == 0) return;
  list_visible(frame);
  find_features();
  find_colors(frame);
}

void FieldPasses::list_changing() const {
  launch("field_gradients", list_field_gaussians<HasGradient>, 2 * kFieldBlocks, stream,
         input_of(*this).lists, field.order.pairs.values.data(), parameters.count,
         HasGradient{field.d_outputs.data()});
}

void FieldPasses::through_network(glm::vec3* d_means) const {
  const FieldInput in = input_of(*this);
  const bool is_short = in.field.inputs <= kPublishedInputs;
  launch("field_gradients", is_short ? backward_tiles<kPublishedInputs> : backward_tiles<kMostRows>,
         Blocks(kFieldBlocks, kNetworkThreads, sizeof(BackwardTile)), stream, in,
         field.d_outputs.data(), field.block_weights.data(), field.weight_count, d_means);
}

void FieldPasses::network_gradients(glm::vec3* d_means) const {
  if (parameters.count == 0) return;
  field.keep_order(parameters, stream);
  list_changing();
  through_network(d_means);
}

void FieldPasses::sum_weight_gradients() const {
  const FieldInput in = input_of(*this);
  const auto weights = static_cast<std::uint32_t>(field.weight_count);
  const std::size_t used =
      field.shape.network().third() + std::size_t{kUsedOutputs} * in.field.width;
  launch("field_gradients", sum_field_blocks, blocks_for(weights), stream, in.lists.by_index,
         field.block_weights.data(), weights, static_cast<std::uint32_t>(used),
         field.by_weights.data());
}

void FieldPasses::sum_grid_gradients() const {
  const FieldInput in = input_of(*this);
  constexpr unsigned kItems = kRuns * kRunSize;
  const unsigned blocks = (kFieldBlocks * in.lists.in_space.block_size + kItems - 1) / kItems;
  launch("field_gradients", sum_runs, blocks * in.field.level_count, stream, in, blocks,
         field.grid_sums.data());
}

void FieldPasses::sum_gradients() const {
  constexpr const char* kWhat = "field_gradients";
  if (field.has_grid_sums) set_zero(kWhat, field.grid_sums.data(), field.grid_count, stream);
  field.has_grid_sums = true;
  if (parameters.count == 0) {
    set_zero(kWhat, field.by_weights.data(), field.weight_count, stream);
    return;
  }
  sum_weight_gradients();
  sum_grid_gradients();
}

void take_field_step(double rate, DeviceField& field, cudaStream_t stream) {
  const auto grid_count = static_cast<std::uint32_t>(field.grid_count);
  const auto count = static_cast<std::uint32_t>(field.grid_count + field.weight_count);
  // A thread per four values: both counts are multiples of 4. The sums become 0. A value that never
  // had a gradient stays as it is, and is not read.
  const auto step_four = [step = AdamStep::number(++field.steps), rate = static_cast<float>(rate),
                          grid_count, values = field.values.data(), firsts = field.first.data(),
                          seconds = field.second.data(), grid_sums = field.grid_sums.data(),
                          by_weights = field.by_weights.data()] __device__(std::uint32_t i) {
    const std::uint32_t at = kNeighbours * i;
    auto first = Neighbours::load(firsts + at), second = Neighbours::load(seconds + at);
    Neighbours by;
    if (at < grid_count) {
      auto* const sums = reinterpret_cast<TwoSums*>(grid_sums + at);
      const TwoSums low = sums[0], high = sums[1];
      const auto derivative = [](unsigned long long sum) {
        return static_cast<float>(static_cast<double>(static_cast<long long>(sum)) * kSumUnit);
      };
      by = {{derivative(low.values[0]), derivative(low.values[1]), derivative(high.values[0]),
             derivative(high.values[1])}};
      if ((low.values[0] | low.values[1]) != 0) sums[0] = TwoSums{{0, 0}};
      if ((high.values[0] | high.values[1]) != 0) sums[1] = TwoSums{{0, 0}};
    } else {
      by = Neighbours::load(by_weights + (at - grid_count));
    }
    if (by.are_zero() && first.are_zero() && second.are_zero()) return;
    auto value = Neighbours::load(values + at);
    step_neighbours(step, rate, by, value, first, second);
    value.store(values + at);
    first.store(firsts + at);
    second.store(seconds + at);
  };
  for_each_item("step_field", count / kNeighbours, stream, step_four);
  field.has_grid_sums = false;
}

}  // namespace qs::cuda::train
