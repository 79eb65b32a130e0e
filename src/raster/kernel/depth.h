// SPDX-License-Identifier: MIT
//
// Alpha and depth of one pixel from the Gaussians that it blends, front to back: see DepthMaps.
#pragma once

#include "raster/kernel/hd.h"

namespace qs {

/// The state of one pixel. Real is float, or double in mode reference.
template <class Real>
struct PixelDepth {
  Real transmittance = 1;
  Real weights = 0, weighted_depths = 0;  ///< sums
  Real median = 0;                        ///< 0 until the transmittance is <= 1/2

  /// Blends a Gaussian of view depth `depth` with alpha 0..1; `next` is the transmittance behind
  /// it.
  QS_HD void add(Real alpha, Real depth, Real next) {
    const Real weight = alpha * transmittance;
    weights += weight;
    weighted_depths += weight * depth;
    if (transmittance > Real(0.5) && next <= Real(0.5)) median = depth;
    transmittance = next;
  }

  QS_HD Real alpha() const { return 1 - transmittance; }
  QS_HD Real expected() const { return weights > 0 ? weighted_depths / weights : Real(0); }
};

}  // namespace qs
