// SPDX-License-Identifier: MIT
//
// The visible Gaussians as the blend stage reads them.
#pragma once

#include "raster/cpu/fast/color.h"
#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/blend.h"

namespace qs::cpu::fast {

/// A visible Gaussian: one cache line. At the offset (dx, dy) from the mean, log2 of 256 alpha is
/// log2_256_opacity - along dx^2 - (scale (dy - slope dx))^2: rounding cannot lift it above
/// log2_256_opacity.
struct alignas(64) Record {
  float mean_x, mean_y;
  float log2_256_opacity;
  float along, slope;
  float height;  ///< px: at least 1 / scale
  float scale;   ///< 1 / px
  float red, green, blue;

  float opacity() const { return exp2_polynomial(log2_256_opacity - 8); }
};

/// Writes records[k] for the k-th survivor.
void make_records(const Survivors& survivors, const Colors& colors, Record* records);

}  // namespace qs::cpu::fast
