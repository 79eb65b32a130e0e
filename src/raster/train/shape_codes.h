// SPDX-License-Identifier: MIT
//
// Models whose scales and rotations are codes: what the passes draw, and the gradient by the values
// that the codes stand for.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <glm/exponential.hpp>
#include <glm/gtc/quaternion.hpp>

#include "raster/base/parallel.h"
#include "raster/train/model_state.h"

namespace qs::train {

inline constexpr float kLeastCodedScale = 1e-12f;

/// The unit quaternion with w >= 0, and the factor by which `rotation` was divided.
inline std::pair<glm::quat, float> turned(const glm::quat& rotation) {
  const float length = std::sqrt(glm::dot(rotation, rotation));
  const float factor = rotation.w < 0 ? -length : length;
  return {rotation / factor, factor};
}

/// Standard deviations, three per Gaussian.
inline std::vector<float> scale_vectors(const Parameters& parameters) {
  std::vector<float> values;
  values.reserve(3 * parameters.size());
  for (const glm::vec3& s : parameters.log_scales)
    values.insert(values.end(), {std::exp(s.x), std::exp(s.y), std::exp(s.z)});
  return values;
}

/// Unit quaternions with w >= 0 as w, x, y, z.
inline std::vector<float> rotation_vectors(const Parameters& parameters) {
  std::vector<float> values;
  values.reserve(4 * parameters.size());
  for (const glm::quat& rotation : parameters.rotations) {
    const glm::quat q = turned(rotation).first;
    values.insert(values.end(), {q.w, q.x, q.y, q.z});
  }
  return values;
}

/// `parameters` with coded shapes. A coded deviation counts by its absolute value, which is at
/// least 1e-12.
inline void code_shapes(const Parameters& parameters, const ShapeCodes& codes, ThreadPool& pool,
                        Parameters& coded_parameters) {
  coded_parameters = parameters;
  const auto scales = coded(codes.scales.codebook, scale_vectors(parameters), pool);
  const auto rotations = coded(codes.rotations.codebook, rotation_vectors(parameters), pool);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const float scale = std::abs(scales[3 * i + static_cast<std::size_t>(k)]);
      coded_parameters.log_scales[i][k] = std::log(std::max(scale, kLeastCodedScale));
    }
    const float* const q = &rotations[4 * i];
    coded_parameters.rotations[i] = glm::quat(q[0], q[1], q[2], q[3]);
  }
}

/// Replaces the derivatives by coded shapes by the derivatives by the shapes of `parameters`,
/// straight through the codes. The sign of a coded deviation does not matter: where it is negative,
/// the deviation that it stands for is near 0.
inline void pass_through_codes(const Parameters& parameters, const Parameters& coded_parameters,
                               ThreadPool& pool, Parameters& by) {
  pool.for_chunks(parameters.size(), 1024, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      by.log_scales[i] *= glm::exp(parameters.log_scales[i] - coded_parameters.log_scales[i]);
      const auto [unit, factor] = turned(parameters.rotations[i]);
      const glm::quat d = by.rotations[i];
      by.rotations[i] = (d - unit * glm::dot(d, unit)) / factor;
    }
  });
}

}  // namespace qs::train
