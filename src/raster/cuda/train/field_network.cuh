// SPDX-License-Identifier: MIT
//
// The network of a colour field in the shared memory of a block, for a tile of Gaussians. A layer
// has a row of the tile's values per input. kTileParts threads share a Gaussian: each computes a
// part of the rows. The threads of a warp read the same weights, four at once. Widths and inputs
// are multiples of 16.
#pragma once

#include "raster/cuda/train/field.cuh"

namespace qs::cuda::train {

inline constexpr unsigned kFieldTile = 64;                     ///< Gaussians
inline constexpr unsigned kTileParts = kThreads / kFieldTile;  ///< threads of a Gaussian
inline constexpr unsigned kUsedOutputs = 3;
inline constexpr unsigned kMostRows = 64;  ///< of a layer
inline constexpr unsigned kChunk = 16;     ///< most rows of a thread
static_assert(kMostRows == kMostFieldInputs && kMostRows == kMostFieldWidth);
static_assert(kMostRows / kTileParts == kChunk);

/// Rows begin four banks apart, so that threads that read different rows do not wait for each
/// other.
inline constexpr unsigned kTileStride = kFieldTile + 4;

using LayerWeights = float[kMostRows][kMostRows];  ///< a row per output

struct alignas(16) Layer {
  float values[kMostRows][kTileStride];
};

struct alignas(16) NetworkWeights {
  LayerWeights first, second;
  float third[kUsedOutputs][kMostRows];

  /// All threads of the block call it; a barrier must follow.
  __device__ void load(const FieldView& field) {
    const unsigned inputs = field.inputs, width = field.width;
    const float* const second_weights = field.weights + width * inputs;
    const float* const third_weights = second_weights + width * width;
    for (unsigned k = threadIdx.x; k < width * inputs; k += kThreads)
      first[k / inputs][k % inputs] = field.weights[k];
    for (unsigned k = threadIdx.x; k < width * width; k += kThreads)
      second[k / width][k % width] = second_weights[k];
    for (unsigned k = threadIdx.x; k < kUsedOutputs * width; k += kThreads)
      third[k / width][k % width] = third_weights[k];
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

/// sum + the products of four weights and values, in their order.
__device__ inline float add_four(const float4& weights, const float* values, float sum) {
  return fmaf(
      weights.w, values[3],
      fmaf(weights.z, values[2], fmaf(weights.y, values[1], fmaf(weights.x, values[0], sum))));
}

__device__ inline float4 four_of(const float* values) {
  return *reinterpret_cast<const float4*>(values);
}

/// y = max(0, weights x), this thread's part of the rows.
__device__ inline void hidden_layer(const LayerWeights& weights, unsigned inputs, unsigned width,
                                    const TileThread& own, const Layer& x, Layer& y) {
  const unsigned rows = width / kTileParts, first = own.part * rows;
  constexpr unsigned kInputs = 8;  // in registers
  float sums[kChunk] = {};
#pragma unroll 1
  for (unsigned begin = 0; begin < inputs; begin += kInputs) {
    float in[kInputs];
#pragma unroll
    for (unsigned k = 0; k < kInputs; ++k) in[k] = x.values[begin + k][own.column];
#pragma unroll
    for (unsigned group = 0; group < kChunk; group += 4) {
      if (group >= rows) break;
#pragma unroll
      for (unsigned k = 0; k < kInputs; k += 4) {
#pragma unroll
        for (unsigned row = group; row < group + 4; ++row)
          sums[row] = add_four(four_of(&weights[first + row][begin + k]), in + k, sums[row]);
      }
    }
  }
#pragma unroll
  for (unsigned row = 0; row < kChunk; ++row) {
    if (row < rows) y.values[first + row][own.column] = sums[row] < 0.0f ? 0.0f : sums[row];
  }
}

/// An output of the network.
__device__ inline float output_of(const NetworkWeights& weights, unsigned output, unsigned width,
                                  unsigned column, const Layer& x) {
  float sum = 0;
  for (unsigned begin = 0; begin < width; begin += 4) {
    float in[4];
#pragma unroll
    for (unsigned k = 0; k < 4; ++k) in[k] = x.values[begin + k][column];
    sum = add_four(four_of(&weights.third[output][begin]), in, sum);
  }
  return sum;
}

/// From the derivatives by the outputs of a layer, of which there are `rows`, to this thread's part
/// of the derivatives by its inputs: `sums[k]` is that by input own.part * inputs / kTileParts + k.
__device__ inline void through_layer(const LayerWeights& weights, unsigned rows, unsigned inputs,
                                     const TileThread& own, const Layer& d, float (&sums)[kChunk]) {
  const unsigned size = inputs / kTileParts, first = own.part * size;
#pragma unroll
  for (unsigned k = 0; k < kChunk; ++k) sums[k] = 0;
#pragma unroll 4
  for (unsigned row = 0; row < rows; ++row) {
    const float by = d.values[row][own.column];
#pragma unroll
    for (unsigned k = 0; k < kChunk; k += 4) {
      if (k >= size) break;
      const float4 weight = four_of(&weights[row][first + k]);
      sums[k] = fmaf(weight.x, by, sums[k]);
      sums[k + 1] = fmaf(weight.y, by, sums[k + 1]);
      sums[k + 2] = fmaf(weight.z, by, sums[k + 2]);
      sums[k + 3] = fmaf(weight.w, by, sums[k + 3]);
    }
  }
}

/// Derivatives by 16 weights of a layer, summed over Gaussians: of outputs row + 16 j and inputs
/// column + 16 k.
struct WeightSums {
  static constexpr unsigned kEvery = 16, kSide = kMostRows / kEvery;
  static_assert(kEvery * kEvery == kThreads);

  float values[kSide][kSide] = {};

  __device__ static unsigned row() { return threadIdx.x / kEvery; }
  __device__ static unsigned column() { return threadIdx.x % kEvery; }

  /// Adds the products of the tile's derivatives by the outputs and its inputs, Gaussian by
  /// Gaussian.
  __device__ void add(const Layer& d, unsigned rows, const Layer& x, unsigned inputs) {
    for (unsigned begin = 0; begin < kFieldTile; begin += 4) {
      float4 by[kSide];
#pragma unroll
      for (unsigned j = 0; j < kSide; ++j) {
        if (j * kEvery < rows) by[j] = four_of(&d.values[row() + j * kEvery][begin]);
      }
#pragma unroll
      for (unsigned k = 0; k < kSide; ++k) {
        if (k * kEvery >= inputs) break;
        const float4 in = four_of(&x.values[column() + k * kEvery][begin]);
        const float four[] = {in.x, in.y, in.z, in.w};
#pragma unroll
        for (unsigned j = 0; j < kSide; ++j) {
          if (j * kEvery < rows) values[j][k] = add_four(by[j], four, values[j][k]);
        }
      }
    }
  }

  /// `to` has a row of `inputs` values per output.
  __device__ void store(unsigned rows, unsigned inputs, float* to) const {
#pragma unroll
    for (unsigned j = 0; j < kSide; ++j) {
#pragma unroll
      for (unsigned k = 0; k < kSide; ++k) {
        if (j * kEvery < rows && k * kEvery < inputs)
          to[(row() + j * kEvery) * inputs + column() + k * kEvery] = values[j][k];
      }
    }
  }
};

}  // namespace qs::cuda::train
