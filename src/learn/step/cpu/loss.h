// SPDX-License-Identifier: MIT
//
// The loss of kernel/loss.h, with its gradient.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "learn/gradient/loss.h"
#include "learn/step/cpu/ssim.h"

namespace qs::cpu::train {

/// A picture and the photograph that it is compared with, both per pixel, row by row.
template <class Real>
struct LossInput {
  int width, height;
  std::span<const glm::vec<3, Real>> color;
  std::span<const glm::vec3> target;
  /// Pixels whose value is 0 are left out and have no derivative. Without a mask all pixels count,
  /// with a mask at least one pixel must count.
  std::span<const std::uint8_t> mask = {};
};

/// Sets `d_color` to the derivatives of the total by the picture's colours. A channel equal to the
/// target's has no derivative of L1. The next step uses the memory of `fields` again.
template <class Real>
Loss compare(const LossInput<Real>& in, ThreadPool& pool, SsimFields<Real>& fields,
             std::vector<glm::vec<3, Real>>& d_color);

}  // namespace qs::cpu::train
