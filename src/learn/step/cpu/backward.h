// SPDX-License-Identifier: MIT
//
// The backward pass of training: from the loss's derivatives by the pixels to its derivatives by
// all parameters. The result does not depend on the number of threads, see learn/diff/cpu/blend.h.
// It joins the backward passes of both, so that no boundary is stored between them.
#pragma once

#include <span>

#include "learn/step/backward_order.h"
#include "learn/step/cpu/forward.h"

namespace qs::cpu::train {

/// Memory of backward() that the next step uses again.
template <class Real>
struct BackwardScratch {
  diff::PairScratch<Real> pairs;
  /// Derivative by Gaussians' colours, with a colour field.
  std::vector<glm::vec<3, Real>> d_colors;
};

/// `frame` is the result of forward() for the same arguments; `d_color` is per pixel, row by row.
/// With a field, the coefficients of colour have no derivatives.
template <class Real>
void backward(const StepView& view, const Parameters<Real>& parameters,
              const ForwardFrame<Real>& frame, std::span<const glm::vec<3, Real>> d_color,
              BackwardScratch<Real>& scratch, Gradients<Real>& gradients,
              const BackwardOrder& order = {}, const FieldGradient<Real>* field = nullptr);

}  // namespace qs::cpu::train
