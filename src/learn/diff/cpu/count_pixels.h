// SPDX-License-Identifier: MIT
//
// Counts the pixels of each Gaussian of a frame.
#pragma once

#include <cstddef>
#include <cstdint>

#include "learn/diff/cpu/frame.h"
#include "learn/diff/strided_arrays.h"
#include "raster/kernel/blend.h"

namespace qs::cpu::diff {

/// Sets counts.at(i), for each of `gaussians` Gaussians, to the number of pixels that blend it and
/// have a transmittance above `behind` after it. blend() makes the same decisions. Throws
/// Cancelled.
template <class Real>
void count_pixels(const PictureSize& size, const PixelRules<Real>& rules,
                  const FrameView<Real>& frame, std::size_t gaussians, Real behind,
                  const Workers& workers, const qs::diff::Rows<std::int32_t>& counts);

}  // namespace qs::cpu::diff
