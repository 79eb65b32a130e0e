// SPDX-License-Identifier: MIT
#include <algorithm>

#include "learn/gradient/integer_sum.h"
#include "learn/gradient/residual_codes.h"
#include "learn/step/cuda/codes.cuh"
#include "raster/cuda/common/dynamic_shared.cuh"
#include "raster/cuda/common/stream.cuh"
#include "raster/kernel/nearest_code.h"

namespace qs::cuda::train {
namespace {

constexpr unsigned kCodeBlocks = 256;                ///< at most, so that sums of blocks are few
constexpr std::size_t kMostSharedBytes = 48 * 1024;  ///< for the sums of a block

/// A codebook as kernels read it. Passed by value.
struct CodesView {
  float *values, *first, *second;
  unsigned long long* sums;
  unsigned layers, count;  ///< codes of a layer

  template <unsigned kDimensions>
  __device__ float* code(unsigned layer, unsigned number) const {
    return values + (std::size_t{layer} * count + number) * kDimensions;
  }
  template <unsigned kDimensions>
  __device__ unsigned nearest(unsigned layer, const float (&vector)[kDimensions]) const {
    return nearest_code(code<kDimensions>(layer, 0), count, kDimensions, vector);
  }
};

struct Scales {
  static constexpr unsigned kDimensions = kScaleValues;
  const glm::vec3* log_scales;
  __device__ void read(std::uint32_t i, float* vector) const {
    scale_vector(log_scales[i], vector);
  }
};
struct Rotations {
  static constexpr unsigned kDimensions = kRotationValues;
  const glm::quat* rotations;
  __device__ void read(std::uint32_t i, float* vector) const {
    rotation_vector(rotations[i], vector);
  }
};

/// The coded vector of Gaussian i.
template <class Vectors>
__device__ void read_coded(const CodesView& codes, const Vectors& vectors, std::uint32_t i,
                           float (&coded)[Vectors::kDimensions]) {
  float rest[Vectors::kDimensions];
  vectors.read(i, rest);
  for (float& value : coded) value = 0;
  for (unsigned layer = 0; layer < codes.layers; ++layer) {
    const float* const nearest =
        codes.code<Vectors::kDimensions>(layer, codes.nearest(layer, rest));
#pragma unroll
    for (unsigned k = 0; k < Vectors::kDimensions; ++k) {
      coded[k] += nearest[k];
      rest[k] -= nearest[k];
    }
  }
}

/// A sum of 64 bits in shared memory, whose atomic additions have 32 bits.
struct SplitSum {
  std::uint32_t low, high;

  __device__ void add(std::int64_t units) {
    const auto bits = static_cast<std::uint64_t>(units);
    const auto more = static_cast<std::uint32_t>(bits);
    const std::uint32_t before = atomicAdd(&low, more);
    const std::uint32_t carry = before + more < before ? 1 : 0;
    atomicAdd(&high, static_cast<std::uint32_t>(bits >> 32) + carry);
  }
  __device__ unsigned long long value() const {
    return static_cast<unsigned long long>(high) << 32 | low;
  }
};

/// The sums of a layer's derivatives: of the block if they fit in its shared memory, else of all.
struct LayerSums {
  unsigned long long* all;
  SplitSum* of_block;  ///< or null

  __device__ void add(unsigned value, std::int64_t units) const {
    if (units == 0) return;
    if (of_block != nullptr)
      of_block[value].add(units);
    else
      atomicAdd(&all[value], static_cast<unsigned long long>(units));
  }
};

/// Adds the derivatives by the codes of a layer to `sums`. `rest` has kDimensions rows; the layer
/// before has moved.
template <class Vectors>
__device__ void add_gaussian(const CodesView& codes, const Vectors& vectors, std::uint32_t i,
                             std::uint32_t count, unsigned layer, float* rest,
                             const LayerSums& sums) {
  constexpr unsigned kDimensions = Vectors::kDimensions;
  float vector[kDimensions];
  if (layer == 0) {
    vectors.read(i, vector);
  } else {
#pragma unroll
    for (unsigned k = 0; k < kDimensions; ++k) vector[k] = rest[std::size_t{k} * count + i];
    const float* const before =
        codes.code<kDimensions>(layer - 1, codes.nearest(layer - 1, vector));
#pragma unroll
    for (unsigned k = 0; k < kDimensions; ++k) vector[k] -= before[k];
  }
  const unsigned number = codes.nearest(layer, vector);
  const float* const code = codes.code<kDimensions>(layer, number);
#pragma unroll
  for (unsigned k = 0; k < kDimensions; ++k) {
    rest[std::size_t{k} * count + i] = vector[k];
    sums.add(number * kDimensions + k, sum_units(code[k] - vector[k]));
  }
}

/// Few codes have many Gaussians, so a block adds up its own before it adds to the sums of all.
template <class Vectors>
__global__ void __launch_bounds__(kThreads)
    add_code_gradients(CodesView codes, Vectors vectors, std::uint32_t count, unsigned layer,
                       float* rest, unsigned shared_sums) {
  auto* const of_block = static_cast<SplitSum*>(dynamic_shared());
  for (unsigned at = threadIdx.x; at < shared_sums; at += kThreads) of_block[at] = {0, 0};
  __syncthreads();
  const LayerSums sums{codes.sums, shared_sums > 0 ? of_block : nullptr};
  for (std::uint32_t i = blockIdx.x * kThreads + threadIdx.x; i < count; i += gridDim.x * kThreads)
    add_gaussian(codes, vectors, i, count, layer, rest, sums);
  __syncthreads();
  for (unsigned at = threadIdx.x; at < shared_sums; at += kThreads)
    if (const unsigned long long sum = of_block[at].value(); sum != 0)
      atomicAdd(&codes.sums[at], sum);
}

CodesView view_of(DeviceCodes& codes) {
  return {codes.values.data(),
          codes.first.data(),
          codes.second.data(),
          codes.sums.data(),
          static_cast<unsigned>(codes.shape.layers),
          static_cast<unsigned>(codes.shape.codes())};
}

template <class Vectors>
void take_step_of(const Vectors& vectors, std::uint32_t count, DeviceCodes& codes, float* rest,
                  cudaStream_t stream) {
  const CodesView view = view_of(codes);
  const AdamStep step = AdamStep::number(++codes.steps);
  const std::size_t values = std::size_t{view.count} * Vectors::kDimensions;
  const std::size_t bytes = values * sizeof(SplitSum);
  const bool fits = bytes <= kMostSharedBytes;
  for (unsigned layer = 0; layer < view.layers; ++layer) {
    launch("step_codes", add_code_gradients<Vectors>,
           Blocks(std::min(blocks_for(count), kCodeBlocks), kThreads, fits ? bytes : 0), stream,
           view, vectors, count, layer, rest, fits ? static_cast<unsigned>(values) : 0);
    // The sums become 0.
    for_each_item("step_codes", static_cast<std::uint32_t>(values), stream,
                  [=] __device__(std::uint32_t at) {
                    const auto units = static_cast<long long>(view.sums[at]);
                    const double sum = static_cast<double>(units) * kSumUnit;
                    view.sums[at] = 0;
                    const std::size_t value = layer * values + at;
                    move_code(step, code_gradient(sum, std::size_t{count} * Vectors::kDimensions),
                              view.values[value], view.first[value], view.second[value]);
                  });
  }
}

}  // namespace

void DeviceCodes::upload(const CodeState& host, cudaStream_t stream) {
  exists = false;
  shape = host.codebook;
  shape.values.clear();
  steps = host.steps;
  if (!host.exists()) return;
  const std::size_t count = host.codebook.value_count();
  const std::size_t of_stage = shape.codes() * shape.dimensions;
  sums.reserve("the codes", of_stage);
  copy_to_device(host.codebook.values.data(), values, count, stream);
  copy_to_device(host.first.data(), first, count, stream);
  copy_to_device(host.second.data(), second, count, stream);
  set_zero("step_codes", sums.data(), of_stage, stream);
  exists = true;
}

void DeviceCodes::download(cudaStream_t stream, CodeState& host) const {
  host.codebook = shape;
  host.steps = steps;
  const std::size_t count = exists ? shape.value_count() : 0;
  copy_to_host(values.data(), host.codebook.values, count, stream);
  copy_to_host(first.data(), host.first, count, stream);
  copy_to_host(second.data(), host.second, count, stream);
}

void ShapeCodes::upload(const qs::train::ShapeCodes& host, cudaStream_t stream) {
  scales.upload(host.scales, stream);
  rotations.upload(host.rotations, stream);
}

void ShapeCodes::download(cudaStream_t stream, qs::train::ShapeCodes& host) const {
  scales.download(stream, host.scales);
  rotations.download(stream, host.rotations);
}

ParametersView ShapeCodes::drawn(ParametersView parameters) {
  parameters.log_scales = coded_scales.data();
  parameters.rotations = coded_rotations.data();
  return parameters;
}

void code_shapes(const ParametersView& parameters, ShapeCodes& codes, cudaStream_t stream) {
  constexpr const char* kWhat = "the coded shapes";
  codes.coded_scales.reserve(kWhat, with_room(parameters.count));
  codes.coded_rotations.reserve(kWhat, with_room(parameters.count));
  codes.rest.reserve(kWhat, kRotationValues * with_room(parameters.count));
  for_each_item("code_shapes", parameters.count, stream,
                [=, scale_codes = view_of(codes.scales), rotation_codes = view_of(codes.rotations),
                 coded_scales = codes.coded_scales.data(),
                 coded_rotations = codes.coded_rotations.data()] __device__(std::uint32_t i) {
                  float scale[kScaleValues], q[kRotationValues];
                  read_coded(scale_codes, Scales{parameters.log_scales}, i, scale);
                  read_coded(rotation_codes, Rotations{parameters.rotations}, i, q);
                  coded_scales[i] = coded_log_scale(scale);
                  coded_rotations[i] = glm::quat(q[0], q[1], q[2], q[3]);
                });
}

void pass_through_codes(const ParametersView& parameters, ShapeCodes& codes,
                        const ParametersView& by, cudaStream_t stream) {
  for_each_item("gradients of codes", parameters.count, stream,
                [=, coded_scales = codes.coded_scales.data()] __device__(std::uint32_t i) {
                  by.log_scales[i] = coded_scale_gradient(parameters.log_scales[i], coded_scales[i],
                                                          by.log_scales[i]);
                  by.rotations[i] =
                      coded_rotation_gradient(parameters.rotations[i], by.rotations[i]);
                });
}

void take_code_steps(const ParametersView& parameters, ShapeCodes& codes, cudaStream_t stream) {
  if (parameters.count == 0) return;
  take_step_of(Scales{parameters.log_scales}, parameters.count, codes.scales, codes.rest.data(),
               stream);
  take_step_of(Rotations{parameters.rotations}, parameters.count, codes.rotations,
               codes.rest.data(), stream);
}

}  // namespace qs::cuda::train
