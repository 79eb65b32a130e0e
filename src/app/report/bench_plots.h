// SPDX-License-Identifier: MIT
//
// The plots of a benchmark: FPS per mode with the range of the rounds, stacked stage times, pairs
// per mode, and frame time against the number of Gaussians if one scene was measured at several
// sizes.
#pragma once

#include <vector>

#include "app/report/bench_report.h"
#include "app/report/plot.h"

namespace qs {

/// `scaling`: the scenes are one scene at several sizes; adds the plot "scaling".
std::vector<Plot> bench_plots(const BenchReport& report, bool scaling);

}  // namespace qs
