// SPDX-License-Identifier: MIT
//
// Times of the kernels of a colour field in training.
#pragma once

#include <vector>

#include "learn/step/model_state.h"
#include "raster/scene/camera.h"

namespace qs::test {

/// Prints the median time of each step of the passes of state.color_field and state.codes on the
/// GPU's clock, over `iterations` of the cameras in turn. Every visible Gaussian has a gradient.
void measure_field_stages(const train::ModelState& state, const std::vector<Camera>& cameras,
                          int iterations);

}  // namespace qs::test
