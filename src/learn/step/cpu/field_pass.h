// SPDX-License-Identifier: MIT
//
// The passes of a colour field: its colours, their gradient and its optimizer's step. Sums do not
// depend on the number of threads, nor on Gaussians without a gradient.
#pragma once

#include <vector>

#include "base/parallel.h"
#include "learn/field/field_gradient.h"
#include "learn/step/cpu/parameters.h"
#include "raster/kernel/color_field.h"

namespace qs::cpu::train {

/// The colour of a Gaussian, as pixels read it.
template <class Real>
glm::vec<3, Real> field_color(const FieldGradient<Real>& field, const glm::vec<3, Real>& mean,
                              const glm::vec<3, Real>& eye) {
  const glm::vec<3, Real> output = field.output(mean, eye);
  return {color_of_output(output.x), color_of_output(output.y), color_of_output(output.z)};
}

/// Adds the derivatives by the field to gradients.by_field, and those by the directions to the
/// means. `d_colors` holds the derivatives by the colour that pixels read, per Gaussian.
template <class Real>
void add_field_gradients(const FieldGradient<Real>& field, const Parameters<Real>& parameters,
                         const glm::vec<3, Real>& eye,
                         const std::vector<glm::vec<3, Real>>& d_colors, ThreadPool& pool,
                         Gradients<Real>& gradients);

/// One step of Adam for all values of the field.
void take_field_step(const FieldGradients<float>& gradients, double rate,
                     qs::train::FieldState& state, ThreadPool& pool);

}  // namespace qs::cpu::train
