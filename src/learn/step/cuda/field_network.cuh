// SPDX-License-Identifier: MIT
//
// The network of a colour field in the shared memory of a block, for a tile of Gaussians. A layer
// has a row of the tile's values per input. A product of a layer's weights and its values has 32
// results per thread, which stay in registers: each value that is read from shared memory takes
// part in 4 or 8 operations. Weights and values beyond the width and the inputs of a network are 0,
// so that all loops have fixed lengths: `kInputs`, the length of the rows of a layer's weights, is
// 48 for the published network, else 64.
#pragma once

#include "learn/step/cuda/field.cuh"

namespace qs::cuda::train {

inline constexpr unsigned kNetworkThreads = 128;                      ///< threads of a block
inline constexpr unsigned kFieldTile = 64;                            ///< Gaussians
inline constexpr unsigned kTileParts = kNetworkThreads / kFieldTile;  ///< threads of a Gaussian
inline constexpr unsigned kUsedOutputs = 3;
inline constexpr unsigned kMostRows = 64;  ///< rows of a layer, at most
inline constexpr unsigned kPublishedInputs = 48;
static_assert(kMostRows == kMostFieldInputs && kMostRows == kMostFieldWidth);
static_assert(kFieldTile == kMostRows);

/// Rows begin four banks apart, so that threads that read different rows do not wait for each
/// other.
inline constexpr unsigned kRowStride = kFieldTile + 4;

struct alignas(16) Layer {
  float values[kMostRows][kRowStride];
};

using LayerWeights = Layer;  ///< a row per output

struct alignas(16) NetworkWeights {
  LayerWeights first, second;
  float third[kUsedOutputs][kMostRows];

  /// All threads of the block call it; a barrier must follow.
  __device__ void load(const FieldView& field) {
    const unsigned inputs = field.inputs, width = field.width;
    const float* const second_weights = field.weights + width * inputs;
    const float* const third_weights = second_weights + width * width;
    for (unsigned k = threadIdx.x; k < kMostRows * kMostRows; k += kNetworkThreads) {
      const unsigned row = k / kMostRows, column = k % kMostRows;
      first.values[row][column] =
          row < width && column < inputs ? field.weights[row * inputs + column] : 0.0f;
      second.values[row][column] =
          row < width && column < width ? second_weights[row * width + column] : 0.0f;
    }
    for (unsigned k = threadIdx.x; k < kUsedOutputs * kMostRows; k += kNetworkThreads) {
      const unsigned row = k / kMostRows, column = k % kMostRows;
      third[row][column] = column < width ? third_weights[row * width + column] : 0.0f;
    }
  }
};

/// A thread's Gaussian in a tile of a block's list.
struct TileThread {
  unsigned column, part;
  bool exists;
  std::uint32_t gaussian = 0;

  /// The tile begins at entry `first` of the block's list.
  __device__ TileThread(const FieldListsView& lists, std::uint32_t block, std::uint32_t first)
      : column(threadIdx.x % kFieldTile),
        part(threadIdx.x / kFieldTile),
        exists(first + column < lists.sizes[block]) {
    if (exists) gaussian = lists.gaussians[std::size_t{block} * lists.block_size + first + column];
  }
};

__device__ inline float4 four_of(const float* values) {
  return *reinterpret_cast<const float4*>(values);
}

/// sum + the products of four pairs of values, in their order.
__device__ inline float add_four(const float4& a, const float4& b, float sum) {
  return fmaf(a.w, b.w, fmaf(a.z, b.z, fmaf(a.y, b.y, fmaf(a.x, b.x, sum))));
}

/// A thread's 32 results of a product: 8 rows and 4 columns. The threads of a warp have 4 rows and
/// 8 columns side by side.
struct Patch {
  static constexpr unsigned kRows = 8, kColumns = 4;
  static_assert(kRows * kColumns * kNetworkThreads == kMostRows * kFieldTile);

  float values[kRows][kColumns] = {};

  __device__ static unsigned row() { return threadIdx.x / 8 % 8; }
  __device__ static unsigned column() { return threadIdx.x % 8 + threadIdx.x / 64 * 8; }

  __device__ void add(unsigned row, float by, const float4& in) {
    values[row][0] = fmaf(by, in.x, values[row][0]);
    values[row][1] = fmaf(by, in.y, values[row][1]);
    values[row][2] = fmaf(by, in.z, values[row][2]);
    values[row][3] = fmaf(by, in.w, values[row][3]);
  }
  __device__ float4 four(unsigned row) const {
    return {values[row][0], values[row][1], values[row][2], values[row][3]};
  }
};

/// Replaces four values that came from max(0, value): where one was 0 there is no derivative.
__device__ inline void replace_where_positive(float* values, const float4& by) {
  auto& four = *reinterpret_cast<float4*>(values);
  four = {four.x > 0.0f ? by.x : 0.0f, four.y > 0.0f ? by.y : 0.0f, four.z > 0.0f ? by.z : 0.0f,
          four.w > 0.0f ? by.w : 0.0f};
}

/// y = max(0, weights x). A thread has the rows row() + 8 j and four neighbouring Gaussians.
template <unsigned kInputs>
__device__ void hidden_layer(const LayerWeights& weights, const Layer& x, Layer& y) {
  const unsigned row = Patch::row(), column = 4 * Patch::column();
  Patch sums;
#pragma unroll 2
  for (unsigned begin = 0; begin < kInputs; begin += 4) {
    float4 in[4];
#pragma unroll
    for (unsigned k = 0; k < 4; ++k) in[k] = four_of(&x.values[begin + k][column]);
#pragma unroll
    for (unsigned j = 0; j < Patch::kRows; ++j) {
      const float4 weight = four_of(&weights.values[row + 8 * j][begin]);
      sums.add(j, weight.x, in[0]);
      sums.add(j, weight.y, in[1]);
      sums.add(j, weight.z, in[2]);
      sums.add(j, weight.w, in[3]);
    }
  }
  const auto positive = [](float value) { return value < 0.0f ? 0.0f : value; };
#pragma unroll
  for (unsigned j = 0; j < Patch::kRows; ++j) {
    const float4 sum = sums.four(j);
    *reinterpret_cast<float4*>(&y.values[row + 8 * j][column]) = {positive(sum.x), positive(sum.y),
                                                                  positive(sum.z), positive(sum.w)};
  }
}

/// An output of the network.
__device__ inline float output_of(const NetworkWeights& weights, unsigned output, unsigned column,
                                  const Layer& x) {
  float sum = 0;
#pragma unroll 4
  for (unsigned begin = 0; begin < kMostRows; begin += 4) {
    const float4 in{x.values[begin][column], x.values[begin + 1][column],
                    x.values[begin + 2][column], x.values[begin + 3][column]};
    sum = add_four(four_of(&weights.third[output][begin]), in, sum);
  }
  return sum;
}

/// Derivatives by a layer's inputs, from those by its outputs. A thread has inputs 2 row() and
/// 2 row() + 1, the same plus 16, 32 and 48, and four neighbouring Gaussians.
template <unsigned kInputs>
struct InputDerivatives {
  static constexpr unsigned kRows = kInputs / 8;
  Patch sums;

  /// Input of sums.values[k].
  __device__ static unsigned input(unsigned k) { return 2 * Patch::row() + k % 2 + k / 2 * 16; }

  __device__ InputDerivatives(const LayerWeights& weights, const Layer& d) {
    const unsigned column = 4 * Patch::column();
#pragma unroll 4
    for (unsigned row = 0; row < kMostRows; ++row) {
      const float4 by = four_of(&d.values[row][column]);
#pragma unroll
      for (unsigned k = 0; k < kRows; k += 2) {
        const float2 weight = *reinterpret_cast<const float2*>(&weights.values[row][input(k)]);
        sums.add(k, weight.x, by);
        sums.add(k + 1, weight.y, by);
      }
    }
  }

  /// See replace_where_positive().
  __device__ void replace_positive(Layer& layer) const {
#pragma unroll
    for (unsigned k = 0; k < kRows; ++k)
      replace_where_positive(&layer.values[input(k)][4 * Patch::column()], sums.four(k));
  }
  __device__ void replace(Layer& layer) const {
#pragma unroll
    for (unsigned k = 0; k < kRows; ++k)
      *reinterpret_cast<float4*>(&layer.values[input(k)][4 * Patch::column()]) = sums.four(k);
  }
};

/// Derivatives by weights of a layer, summed over Gaussians: of outputs row() + 8 j and inputs
/// column() + 16 k.
template <unsigned kInputs>
struct WeightSums {
  static constexpr unsigned kColumns = kInputs / 16;
  float values[Patch::kRows][kColumns] = {};

  /// Adds the products of the tile's derivatives by the outputs and its inputs, Gaussian by
  /// Gaussian.
  __device__ void add(const Layer& d, const Layer& x) {
    const unsigned row = Patch::row(), column = Patch::column();
#pragma unroll 2
    for (unsigned begin = 0; begin < kFieldTile; begin += 4) {
      float4 in[kColumns];
#pragma unroll
      for (unsigned k = 0; k < kColumns; ++k) in[k] = four_of(&x.values[column + 16 * k][begin]);
#pragma unroll
      for (unsigned j = 0; j < Patch::kRows; ++j) {
        const float4 by = four_of(&d.values[row + 8 * j][begin]);
#pragma unroll
        for (unsigned k = 0; k < kColumns; ++k) values[j][k] = add_four(by, in[k], values[j][k]);
      }
    }
  }

  /// `to` has a row of `inputs` values per output, of which there are `rows`.
  __device__ void store(unsigned rows, unsigned inputs, float* to) const {
#pragma unroll
    for (unsigned j = 0; j < Patch::kRows; ++j) {
#pragma unroll
      for (unsigned k = 0; k < kColumns; ++k) {
        const unsigned row = Patch::row() + 8 * j, column = Patch::column() + 16 * k;
        if (row < rows && column < inputs) to[row * inputs + column] = values[j][k];
      }
    }
  }
};

/// The same for the used outputs of the last layer: a thread has a column of the weights, and every
/// kTileParts-th output.
struct LastWeightSums {
  static constexpr unsigned kOutputs = (kUsedOutputs + kTileParts - 1) / kTileParts;
  float values[kOutputs] = {};

  __device__ static unsigned column() { return threadIdx.x % kMostRows; }
  __device__ static unsigned output(unsigned j) { return threadIdx.x / kMostRows + j * kTileParts; }

  /// `d` are the derivatives by the outputs.
  __device__ void add(const float (&d)[kUsedOutputs][kRowStride], const Layer& x) {
#pragma unroll 2
    for (unsigned begin = 0; begin < kFieldTile; begin += 4) {
      const float4 in = four_of(&x.values[column()][begin]);
#pragma unroll
      for (unsigned j = 0; j < kOutputs; ++j)
        if (output(j) < kUsedOutputs)
          values[j] = add_four(four_of(&d[output(j)][begin]), in, values[j]);
    }
  }

  __device__ void store(unsigned width, float* to) const {
#pragma unroll
    for (unsigned j = 0; j < kOutputs; ++j)
      if (column() < width && output(j) < kUsedOutputs)
        to[output(j) * width + column()] = values[j];
  }
};

}  // namespace qs::cuda::train
