// SPDX-License-Identifier: MIT
//
// A benchmark as Markdown tables in the layout of the paper: one per scene with means over its
// cameras, and one with means over the scenes.
#pragma once

#include <string>
#include <vector>

#include "app/report/bench_report.h"

namespace qs {

/// One mode of one pipeline on one scene, averaged over the cameras.
struct ModeMean {
  std::string scene, mode, pipeline;
  std::string label;  ///< the mode, followed by its pipeline if the rows have several pipelines
  double gaussians = 0, pairs = 0, sort_bytes = 0;
  double ms = 0, ms_p05 = 0, ms_p95 = 0;  ///< means of the cameras' medians and percentiles
  double stage_ms[4] = {};                ///< index = Stage
  std::optional<double> psnr;             ///< mean over the cameras, if all have one
  std::optional<double> speedup;          ///< ms of the pipeline's 3dgs / ms, if it was measured
  double fps() const { return 1000 / ms; }
};

/// One entry per scene and mode, in the order of their first rows.
std::vector<ModeMean> mode_means(const std::vector<BenchRow>& rows);

std::string format_markdown(const BenchReport& report);

}  // namespace qs
