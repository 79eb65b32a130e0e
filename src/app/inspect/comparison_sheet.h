// SPDX-License-Identifier: MIT
//
// Draws a ViewComparison as papers print it: a column per variant with the crop, its amplified
// difference from the truth, and its numbers. Also formats it as a table.
#pragma once

#include <string>

#include "app/inspect/view_comparison.h"
#include "base/parallel.h"

namespace qs {

/// `where`: scene and view for the headline. `pool` scales the images.
Image draw_comparison(const ViewComparison& comparison, int amplification, const std::string& where,
                      ThreadPool& pool);

/// A table with a line per variant: PSNR, largest difference, pairs, false positives.
std::string format_comparison(const ViewComparison& comparison);

}  // namespace qs
