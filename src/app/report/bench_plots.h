// SPDX-License-Identifier: MIT
//
// The plots of a benchmark: FPS per mode with its 5-95 % range, stage times stacked, pairs per
// mode, and cost against the number of Gaussians when one scene was measured at several sizes.
#pragma once

#include <vector>

#include "app/report/bench_report.h"
#include "app/report/plot.h"

namespace qs {

/// `scaling`: the scenes are one scene at several sizes; adds their curve.
std::vector<Plot> bench_plots(const BenchReport& report, bool scaling);

}  // namespace qs
