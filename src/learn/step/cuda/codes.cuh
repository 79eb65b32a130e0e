// SPDX-License-Identifier: MIT
//
// Codes of scales and rotations in training on the GPU, see learn/step/shape_codes.h. Equal
// shapes give the codes of the CPU, bit for bit.
#pragma once

#include <cstdint>

#include "learn/step/cuda/parameters.cuh"
#include "learn/step/model_state.h"

namespace qs::cuda::train {

/// A codebook in training.
struct DeviceCodes {
  ResidualCodebook shape;  ///< without values
  DeviceBuffer<float> values, first, second;
  DeviceBuffer<unsigned long long> sums;  ///< sums of a layer's derivatives; zero between steps
  std::uint64_t steps = 0;
  bool exists = false;

  void upload(const CodeState& host, cudaStream_t stream);
  void download(cudaStream_t stream, CodeState& host) const;
};

struct ShapeCodes {
  DeviceCodes scales, rotations;
  // Per Gaussian.
  DeviceBuffer<glm::vec3> coded_scales;  ///< logarithms
  DeviceBuffer<glm::quat> coded_rotations;
  DeviceBuffer<float> rest;  ///< remainder of a vector after the layers before

  bool exist() const { return scales.exists; }
  /// Replaces the codes. Throws Error(device).
  void upload(const qs::train::ShapeCodes& host, cudaStream_t stream);
  /// Waits.
  void download(cudaStream_t stream, qs::train::ShapeCodes& host) const;

  /// `parameters` with the shapes of code_shapes().
  ParametersView drawn(ParametersView parameters);
};

/// Codes the shapes. Throws Error(device) if memory is short.
void code_shapes(const ParametersView& parameters, ShapeCodes& codes, cudaStream_t stream);

/// Replaces the derivatives by coded shapes by the derivatives by the shapes of `parameters`.
void pass_through_codes(const ParametersView& parameters, ShapeCodes& codes,
                        const ParametersView& by, cudaStream_t stream);

/// One step of all codes, after code_shapes(); see take_code_step() of the CPU.
void take_code_steps(const ParametersView& parameters, ShapeCodes& codes, cudaStream_t stream);

}  // namespace qs::cuda::train
