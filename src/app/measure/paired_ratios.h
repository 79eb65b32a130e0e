// SPDX-License-Identifier: MIT
//
// The speed of the modes of a benchmark relative to a baseline. Times are paired: each is compared
// with the baseline's time of the same scene, camera, pipeline and round, so differences between
// cameras and slow changes of the machine cancel.
#pragma once

#include <string>
#include <vector>

#include "app/measure/bench_row.h"
#include "app/measure/ratio.h"

namespace qs {

inline constexpr const char* kUsualBaseline = "3dgs";
inline constexpr std::size_t kFewestFrames = 5;  ///< a ratio needs this many frames

/// True if `frames`, of BenchRow::frames, suffice for a ratio. An unknown number does.
inline bool are_enough_frames(std::optional<std::uint64_t> frames) {
  return !frames || *frames >= kFewestFrames;
}

/// The ratio baseline time / time of a mode.
struct PairedRatio {
  std::string scene, camera;  ///< `camera` is empty for the ratio over all cameras of the scene
  std::string mode, pipeline;
  Ratio ratio;  ///< the samples are rounds for one camera, cameras for several
};

/// The medians of the row's rounds. A row without them counts as one round.
std::vector<double> rounds_of(const BenchRow& row);

/// The ratio of two rows of one view, over the rounds that both have; if both have a single round,
/// over its frames. Unset without times.
std::optional<Ratio> paired_ratio(const BenchRow& base, const BenchRow& row);

/// For each scene, pipeline and mode except the baseline, in the order of the rows: the ratios of
/// the cameras, then their geometric mean. The mean over one camera is the ratio of that camera.
/// Views that lack the baseline are left out, and ratios of fewer than kFewestFrames frames.
std::vector<PairedRatio> paired_ratios(const std::vector<BenchRow>& rows,
                                       const std::string& baseline);

}  // namespace qs
