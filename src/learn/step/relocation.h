// SPDX-License-Identifier: MIT
//
// Copies of a Gaussian share its place (Kheradmand et al. 2024, arXiv 2404.09591, equation 9):
// their opacity and scale, with which all copies together look about as the one Gaussian did.
#pragma once

namespace qs::train {

inline constexpr int kMostCopies = 51;  ///< as in the published code

struct Relocation {
  double opacity;       ///< opacity of every copy
  double scale_factor;  ///< on the standard deviations
};

/// For `copies` of 1..kMostCopies Gaussians in the place of one of this opacity, 0..1. If the
/// formula has no finite result, as for opacity 0, the factor is 1.
Relocation relocated(double opacity, int copies);

}  // namespace qs::train
