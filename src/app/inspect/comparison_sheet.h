// SPDX-License-Identifier: MIT
//
// A comparison of one view as papers print it: a column per variant with the crop, its difference
// from the truth, amplified, and its numbers below.
#pragma once

#include <string>

#include "app/inspect/view_comparison.h"
#include "raster/base/parallel.h"

namespace qs {

/// `where`: scene and view, for the headline. `pool` scales the images.
Image draw_comparison(const ViewComparison& comparison, int amplification, const std::string& where,
                      ThreadPool& pool);

/// A line per variant: PSNR, largest difference, pairs, false positives.
std::string format_comparison(const ViewComparison& comparison);

}  // namespace qs
