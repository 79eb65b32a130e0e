// SPDX-License-Identifier: MIT
//
// The pixels that a picture gets wrong, as both backends decide it. The error of a pixel is the
// mean over its channels of |picture - photograph|. Errors are counted in bins, so the limit
// depends on integers only. The limit is a share of the picture's own large errors: of the quantile
// kHighErrors, which a few bad pixels do not move. So it needs no scale of errors, and holds for
// pictures of every size.
#pragma once

#include <cmath>
#include <cstdint>

#include <glm/vec3.hpp>

#include "learn/gradient/loss.h"
#include "raster/kernel/hd.h"

namespace qs {

inline constexpr unsigned kErrorBins = 1024;  ///< error bins of equal width, from 0 to 1
/// The error of a pixel that is masked out.
inline constexpr std::uint16_t kMaskedError = 0xffff;
inline constexpr unsigned kHighErrors = 100;  ///< 1 of so many pixels has a larger error
inline constexpr unsigned kLimitNumerator = 1, kLimitDenominator = 4;

/// The bin of a pixel's error. The photograph's values are 0..1.
QS_HD std::uint16_t error_bin(const glm::vec3& picture, const glm::vec3& photograph) {
  float sum = 0;
  for (int c = 0; c < 3; ++c) sum += std::abs(shown(picture[c]) - photograph[c]);
  const float bin = sum * (static_cast<float>(kErrorBins) / 3);
  // A value that is not a number has the largest error.
  return static_cast<std::uint16_t>(bin < kErrorBins - 1 ? bin : kErrorBins - 1);
}

/// Pixels in bins above the result are flagged. `histogram` has the number of pixels per bin.
QS_HD std::uint16_t error_limit(const std::uint32_t* histogram) {
  std::uint32_t total = 0;
  for (unsigned bin = 0; bin < kErrorBins; ++bin) total += histogram[bin];
  const std::uint32_t most = total / kHighErrors;  // pixels above the quantile
  unsigned high = kErrorBins - 1;
  for (std::uint32_t above = 0; high > 0; --high) {
    above += histogram[high];
    if (above > most) break;
  }
  return static_cast<std::uint16_t>(high * kLimitNumerator / kLimitDenominator);
}

}  // namespace qs
