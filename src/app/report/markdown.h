// SPDX-License-Identifier: MIT
//
// A benchmark as Markdown tables in the layout of the paper: a table per scene with means over its
// cameras, and a table with means over the scenes. If a baseline was chosen, each scene also has a
// table of the ratios of its cameras.
#pragma once

#include <string>
#include <vector>

#include "app/report/bench_report.h"

namespace qs {

/// One mode of one pipeline on one scene, averaged over the cameras.
struct ModeMean {
  std::string scene, mode, pipeline;
  std::string label;  ///< the mode, followed by its pipeline if the rows have several pipelines
  double gaussians = 0, pairs = 0;
  std::optional<double> sort_bytes;        ///< set if all cameras have a value
  double ms = 0;                           ///< mean of the cameras' medians
  double ms_fastest = 0, ms_slowest = 0;   ///< means of the cameras' fastest and slowest rounds
  std::optional<double> ms_spread;         ///< mean of the cameras' spread_ms(), if all have one
  bool noisy = false;                      ///< is_noisy(), by the means of the cameras' values
  bool enough_frames = true;               ///< false: too few for a ratio
  std::size_t rounds = 0;                  ///< smallest number of rounds of a camera
  double stage_ms[4] = {};                 ///< index = Stage
  std::optional<double> psnr, ssim, flip;  ///< means over the cameras, if all have a value
  /// true if every camera's frames repeat; unset if a camera lacks it
  std::optional<bool> repeats;
  bool plugin = false;         ///< pairs of 0 are not measured
  std::optional<Ratio> ratio;  ///< the ratio to the baseline in the same pipeline, if measured
  /// 1000 / the mean of the cameras' ms_paper; over scenes the arithmetic mean
  std::optional<double> fps_paper;
  double fps() const { return 1000 / ms; }
};

/// One entry per scene and mode, in the order of their first rows.
std::vector<ModeMean> mode_means(const std::vector<BenchRow>& rows, const std::string& baseline);

/// The different texts of a member, in the order of their first entries.
std::vector<std::string> different(const std::vector<ModeMean>& means,
                                   std::string ModeMean::*member);

/// Means over the scenes, one entry per label, in the order of their first entries. Values are
/// arithmetic means. The ratio is a geometric mean without an interval, because scenes are chosen
/// and not a random sample of all scenes.
std::vector<ModeMean> over_scenes(const std::vector<ModeMean>& means);

std::string format_markdown(const BenchReport& report);

}  // namespace qs
