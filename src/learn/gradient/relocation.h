// SPDX-License-Identifier: MIT
//
// Copies of a Gaussian share its place (Kheradmand et al. 2024, arXiv 2404.09591, equation 9):
// their opacity and scale, with which all copies together look about as the one Gaussian did.
#pragma once

#include <cmath>

#include "raster/kernel/hd.h"

namespace qs {

inline constexpr int kMostCopies = 51;  ///< as in the published code

struct Relocation {
  double opacity;       ///< opacity of every copy
  double scale_factor;  ///< on the standard deviations
};

/// For `copies` of 1..kMostCopies Gaussians in the place of one of this opacity, 0..1. If the
/// formula has no finite result, as for opacity 0, the factor is 1.
QS_HD Relocation relocated(double opacity, int copies) {
  const double after = 1 - std::pow(1 - opacity, 1.0 / copies);
  double sum = 0;
  for (int n = 1; n <= copies; ++n) {
    double binomial = 1;  // of n - 1 and k
    for (int k = 0; k < n; ++k) {
      sum += binomial * (k % 2 == 0 ? 1 : -1) * std::pow(after, k + 1.0) / std::sqrt(k + 1.0);
      binomial = binomial * (n - 1 - k) / (k + 1);
    }
  }
  const double factor = opacity / sum;
  return {after, factor > 0 && factor - factor == 0 ? factor : 1};
}

/// As relocated(), for any number of copies. An opacity outside of 0..1 stays, with its scale.
QS_HD Relocation shared_place(double opacity, int copies) {
  const bool stays = copies <= 1 || !(opacity >= 0 && opacity <= 1);
  return stays ? Relocation{opacity, 1}
               : relocated(opacity, copies < kMostCopies ? copies : kMostCopies);
}

}  // namespace qs
