// SPDX-License-Identifier: MIT
//
// Counts the pixels of a view that blend each Gaussian, and the pixels among them with a large
// error. It walks the lists of the forward pass a second time. The counts are integers, so the
// order of threads does not matter.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "learn/step/cpu/forward.h"
#include "learn/step/plan.h"

namespace qs::cpu::train {

/// Adds the view's pixels to `counts`, which has an element for every Gaussian or is empty. `frame`
/// is the result of forward(); `target` is the photograph per pixel, row by row; `mask` as in
/// LossInput.
void count_errors(const StepView& view, const ForwardFrame<float>& frame,
                  std::span<const glm::vec3> target, std::span<const std::uint8_t> mask,
                  std::size_t gaussians, PixelCounts& counts);

}  // namespace qs::cpu::train
