// SPDX-License-Identifier: MIT
//
// Evaluates a colour field for many Gaussians, in single precision, with parameters rounded to half
// precision as the published files hold them. tiny-cuda-nn keeps all intermediate values in half
// precision too: its features differ by up to 6e-4 and its outputs by up to 3e-4.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "raster/field/color_field.h"
#include "raster/field/field_vectors.h"

namespace qs {

class FieldEvaluator {
 public:
  explicit FieldEvaluator(const ColorField& field);

  /// One triple of network_output() per mean, for the direction from `eye` to it. Spans have equal
  /// sizes. Threads may call this at the same time.
  void outputs(std::span<const glm::vec3> means, const glm::vec3& eye,
               std::span<glm::vec3> out) const;

  /// Spherical harmonics of degree 3 of the colours, as a GaussianCloud holds them: 16 triples per
  /// mean, from 24 directions. `rms` receives each mean's root of the mean square of the difference
  /// between both in these directions, of all three channels, in units of 0..1. Threads may call
  /// this at the same time.
  void fit_sh(std::span<const glm::vec3> means, std::span<glm::vec3> sh,
              std::span<float> rms) const;

 private:
  field_vectors::Packed packed_;
};

}  // namespace qs
