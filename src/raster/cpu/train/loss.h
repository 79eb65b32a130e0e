// SPDX-License-Identifier: MIT
//
// The loss of a picture against a photograph, with its gradient (Kerbl et al. 2023):
//   (1 - w) L1 + w (1 - SSIM),   w = 0.2
// L1 is the mean of absolute differences over pixels and channels. SSIM is that of
// scene/image_metrics.h: window 11 x 11, sigma 1.5, zeros outside, mean over pixels and channels.
// Masked pixels are not in the means and count as outside of both pictures.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "raster/base/parallel.h"

namespace qs::cpu::train {

inline constexpr double kSsimWeight = 0.2;

struct Loss {
  double total = 0;
  double l1 = 0, ssim = 0;
  double squared_error = 0;  ///< mean over pixels and channels, of the clamped picture
};

/// Memory of compare() that the next step uses again.
template <class Real>
struct LossScratch {
  std::vector<Real> fields[5], rows;
};

/// Compares `color` with `target`, both per pixel, row by row, and sets `d_color` to the
/// derivatives of the total by `color`. A channel equal to the target's has no derivative of L1.
/// Pixels whose value in `mask` is 0 are left out and have no derivative; without a mask all count,
/// otherwise at least one must.
template <class Real>
Loss compare(int width, int height, std::span<const glm::vec<3, Real>> color,
             std::span<const glm::vec3> target, ThreadPool& pool, LossScratch<Real>& scratch,
             std::vector<glm::vec<3, Real>>& d_color, std::span<const std::uint8_t> mask = {});

}  // namespace qs::cpu::train
