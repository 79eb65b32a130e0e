// SPDX-License-Identifier: MIT
//
// The first pass of the differentiable rasterizer: projects activated Gaussians, lists them in
// tiles and sorts the lists. Its backward pass goes from the boundary to all inputs and to the
// camera. No result depends on the number of threads.
#pragma once

#include <span>

#include "learn/diff/cpu/frame.h"
#include "learn/diff/gaussians.h"
#include "learn/diff/rules.h"

namespace qs::cpu::diff {

/// Fills `frame`, and all wanted arrays of the boundary. `radii` gets 2 numbers per Gaussian by the
/// rules' formula. Throws Error(usage) for inputs that do not fit together, Error(device) if the
/// tile lists do not fit into memory, and Cancelled.
template <class Real>
void project(const DrawnView& view, const GaussianInputs<Real>& gaussians, const Workers& workers,
             ProjectedFrame<Real>& frame, const Boundary<Real>& out = {},
             const Rows<std::int32_t>& radii = {});

/// `projected` is ProjectedFrame::projected for the same view and Gaussians; `by` are the
/// derivatives by the boundary, each of which may be missing. Writes all rows of the wanted arrays
/// of given inputs: 0 for Gaussians without a row in the boundary. Also writes `pose` if it is not
/// null; its sums are in double precision. Throws Error(usage) and Cancelled.
template <class Real>
void project_backward(const DrawnView& view, const GaussianInputs<Real>& gaussians,
                      std::span<const std::uint8_t> projected, const Boundary<const Real>& by,
                      const Workers& workers, const InputGradients<Real>& out,
                      PoseGradient* pose = nullptr);

}  // namespace qs::cpu::diff
