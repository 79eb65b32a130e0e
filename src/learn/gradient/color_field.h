// SPDX-License-Identifier: MIT
//
// The gradient of color_field.h: from the network's inputs to the direction, and from the colour to
// the network's output.
#pragma once

#include <glm/vec3.hpp>

#include "learn/gradient/sh.h"
#include "raster/kernel/color_field.h"
#include "raster/kernel/constants.h"
#include "raster/kernel/hd.h"

namespace qs {

/// Passes derivatives on from encode_direction(d) to d. `by` holds the derivatives by the
/// kDirectionFeatures features.
template <class Real>
QS_HD glm::vec<3, Real> direction_features_gradient(const glm::vec<3, Real>& d, const Real* by) {
  const Real x = 2 * d.x - 1, y = 2 * d.y - 1, z = 2 * d.z - 1;
  const Real by_x =
      -Real(kSh1) * by[3] + Real(kSh2A) * (y * by[4] - z * by[7]) + 2 * Real(kSh2C) * x * by[8];
  const Real by_y =
      -Real(kSh1) * by[1] + Real(kSh2A) * (x * by[4] - z * by[5]) - 2 * Real(kSh2C) * y * by[8];
  const Real by_z =
      Real(kSh1) * by[2] - Real(kSh2A) * (y * by[5] + x * by[7]) + 6 * Real(kSh2B) * z * by[6];
  return {2 * by_x, 2 * by_y, 2 * by_z};
}

/// Passes derivatives on from color_of_output(), whose result is `color`, to the network's outputs.
/// A channel that is clamped at 0 passes a derivative on if a step against it makes the channel
/// brighter. Otherwise the network could never leave a state in which all its colours are black.
template <class Real>
QS_HD glm::vec<3, Real> output_gradient(const glm::vec<3, Real>& color,
                                        const glm::vec<3, Real>& d_color) {
  glm::vec<3, Real> result;
  for (int c = 0; c < 3; ++c) {
    const bool passes = color[c] > 0 || d_color[c] < 0;
    result[c] = passes ? static_cast<Real>(kSh0) * d_color[c] : Real(0);
  }
  return result;
}

}  // namespace qs
