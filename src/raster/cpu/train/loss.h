// SPDX-License-Identifier: MIT
//
// The loss of kernel/loss.h, with its gradient.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "raster/base/parallel.h"
#include "raster/kernel/loss.h"

namespace qs::cpu::train {

using qs::Loss;

/// Memory of compare() that the next step uses again.
template <class Real>
struct LossScratch {
  std::vector<Real> fields[5], rows;
};

/// Compares `color` with `target`, both per pixel, row by row, and sets `d_color` to the
/// derivatives of the total by `color`. A channel equal to the target's has no derivative of L1.
/// Pixels whose value in `mask` is 0 are left out and have no derivative; without a mask all pixels
/// count, with a mask at least one pixel must count.
template <class Real>
Loss compare(int width, int height, std::span<const glm::vec<3, Real>> color,
             std::span<const glm::vec3> target, ThreadPool& pool, LossScratch<Real>& scratch,
             std::vector<glm::vec<3, Real>>& d_color, std::span<const std::uint8_t> mask = {});

}  // namespace qs::cpu::train
