// SPDX-License-Identifier: MIT
//
// Models whose scales and rotations are codes: what the passes draw, and the gradient by the values
// that the codes stand for.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "base/parallel.h"
#include "learn/gradient/residual_codes.h"
#include "learn/step/model_state.h"

namespace qs::train {

/// Standard deviations, three per Gaussian.
inline std::vector<float> scale_vectors(const Parameters& parameters) {
  std::vector<float> values(kScaleValues * parameters.size());
  for (std::size_t i = 0; i < parameters.size(); ++i)
    scale_vector(parameters.log_scales[i], &values[kScaleValues * i]);
  return values;
}

/// Unit quaternions with w >= 0 as w, x, y, z.
inline std::vector<float> rotation_vectors(const Parameters& parameters) {
  std::vector<float> values(kRotationValues * parameters.size());
  for (std::size_t i = 0; i < parameters.size(); ++i)
    rotation_vector(parameters.rotations[i], &values[kRotationValues * i]);
  return values;
}

/// `parameters` with coded shapes.
inline void code_shapes(const Parameters& parameters, const ShapeCodes& codes, ThreadPool& pool,
                        Parameters& coded_parameters) {
  coded_parameters = parameters;
  const auto scales = coded(codes.scales.codebook, scale_vectors(parameters), pool);
  const auto rotations = coded(codes.rotations.codebook, rotation_vectors(parameters), pool);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    coded_parameters.log_scales[i] = coded_log_scale(&scales[kScaleValues * i]);
    const float* const q = &rotations[kRotationValues * i];
    coded_parameters.rotations[i] = glm::quat(q[0], q[1], q[2], q[3]);
  }
}

/// Replaces the derivatives by coded shapes by the derivatives by the shapes of `parameters`.
inline void pass_through_codes(const Parameters& parameters, const Parameters& coded_parameters,
                               ThreadPool& pool, Parameters& by) {
  pool.for_each(parameters.size(), 1024, [&](std::size_t i) {
    by.log_scales[i] = coded_scale_gradient(parameters.log_scales[i],
                                            coded_parameters.log_scales[i], by.log_scales[i]);
    by.rotations[i] = coded_rotation_gradient(parameters.rotations[i], by.rotations[i]);
  });
}

}  // namespace qs::train
