// SPDX-License-Identifier: MIT
//
// The values of a scene that training changes, on the GPU, and the loss's gradient by them.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "learn/gradient/adam.h"
#include "learn/gradient/gaussian.h"
#include "learn/step/plan.h"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::train {

/// At least `count`, in steps of up to a quarter, so that a growing set seldom allocates.
inline std::size_t with_room(std::size_t count) {
  const std::size_t step = std::bit_floor(std::max<std::size_t>(count, 4)) / 4;
  return (count + step - 1) / step * step;
}

/// The length of an array of `count` coefficients, of which the next one begins at the beginning of
/// a line of the caches.
inline std::uint32_t sh_row(std::uint32_t count) { return (count + 31) / 32 * 32; }

/// The pointers that kernels use. Passed by value.
struct ParametersView {
  glm::vec3 *means, *log_scales;
  glm::quat* rotations;
  float* opacity_logits;
  float* mask_logits;  ///< null without masks
  float* sh;           ///< row 3 k + c, of `sh_row` values: channel c of coefficient k
  std::uint32_t count, sh_row;
  int sh_degree, sh_coefficients;

  bool has_masks() const { return mask_logits != nullptr; }

  __device__ GaussianValues<float> gaussian(std::uint32_t i) const {
    return {means[i], log_scales[i], rotations[i], opacity_logits[i],
            mask_logits != nullptr ? mask_logits[i] : kFirstMaskLogit};
  }
  __device__ void set_gaussian(std::uint32_t i, const GaussianValues<float>& values) const {
    means[i] = values.mean;
    log_scales[i] = values.log_scale;
    rotations[i] = values.rotation;
    opacity_logits[i] = values.opacity_logit;
    if (mask_logits != nullptr) mask_logits[i] = values.mask_logit;
  }

  __device__ glm::vec3 coefficient(std::uint32_t i, int k) const {
    const float* red = sh + std::size_t{3} * k * sh_row + i;
    return {red[0], red[sh_row], red[std::size_t{2} * sh_row]};
  }
  __device__ void set_coefficient(std::uint32_t i, int k, const glm::vec3& value) const {
    float* red = sh + std::size_t{3} * k * sh_row + i;
    red[0] = value.x;
    red[sh_row] = value.y;
    red[std::size_t{2} * sh_row] = value.z;
  }
};

struct Parameters {
  DeviceBuffer<glm::vec3> means, log_scales;
  DeviceBuffer<glm::quat> rotations;
  DeviceBuffer<float> opacity_logits, mask_logits, sh;
  std::uint32_t count = 0;
  int sh_degree = kMaxShDegree;
  bool has_masks = false;

  /// Undefined values. Throws Error(device).
  void resize(std::uint32_t gaussians, int degree, bool masks);
  /// Resizes the arrays but the coefficients of colour.
  void resize_shapes(std::uint32_t gaussians, bool masks);

  ParametersView view() {
    return {means.data(),
            log_scales.data(),
            rotations.data(),
            opacity_logits.data(),
            has_masks ? mask_logits.data() : nullptr,
            sh.data(),
            count,
            sh_row(count),
            sh_degree,
            sh_coefficient_count(sh_degree)};
  }
};

/// The same arrays hold derivatives, except those by the coefficients of colour.
struct Gradients {
  Parameters by;
  /// Zero for the Gaussians that are not visible. The coefficients above `sh_degree` have no
  /// derivative.
  DeviceBuffer<ColorGradient<float>> colors;
  int sh_degree = 0;
  DeviceBuffer<glm::vec2> mean_px;      ///< derivative by the means on the image
  DeviceBuffer<glm::vec2> absolute_px;  ///< as the CPU's, if has_absolute
  bool has_absolute = false;
};

/// Copies `count` values to the GPU and waits.
template <class T>
void copy_to_device(const T* from, DeviceBuffer<T>& to, std::size_t count, cudaStream_t stream) {
  to.reserve("the model", count);
  cuda::copy_to_device(from, count, to.data(), stream);
  check(cudaStreamSynchronize(stream), "copy to the GPU");
}

/// Replaces `parameters` by the host's. Throws Error(device).
void upload(const qs::train::Parameters& host, cudaStream_t stream, Parameters& parameters);

/// The inverse. Waits.
qs::train::Parameters download(const Parameters& parameters, cudaStream_t stream);

/// Gaussian i of `to` becomes Gaussian sources[i] of `from`, or zeros where that is Plan::kZeros.
void gather(Parameters& from, const DeviceBuffer<std::uint32_t>& sources, std::uint32_t count,
            cudaStream_t stream, Parameters& to);

inline constexpr unsigned kNeighbours = 4;

/// Four neighbouring values, which a thread reads and writes at once.
struct Neighbours {
  float4 values;

  static __device__ Neighbours load(const float* from) {
    return {*reinterpret_cast<const float4*>(from)};
  }
  __device__ void store(float* to) const { *reinterpret_cast<float4*>(to) = values; }
  __device__ float& operator[](unsigned n) { return (&values.x)[n]; }
  __device__ bool are_zero() const {
    return values.x == 0 && values.y == 0 && values.z == 0 && values.w == 0;
  }
};

/// adam() of each value.
__device__ inline void step_neighbours(const AdamStep& step, float rate, const Neighbours& by,
                                       Neighbours& value, Neighbours& first, Neighbours& second) {
  adam(step, rate, by.values.x, value.values.x, first.values.x, second.values.x);
  adam(step, rate, by.values.y, value.values.y, first.values.y, second.values.y);
  adam(step, rate, by.values.z, value.values.z, first.values.z, second.values.z);
  adam(step, rate, by.values.w, value.values.w, first.values.w, second.values.w);
}

}  // namespace qs::cuda::train
