// SPDX-License-Identifier: MIT
//
// The speed of the modes of a benchmark relative to a baseline, with confidence intervals. Times
// are paired: each is compared with the baseline's time of the same scene, camera, pipeline and
// round, so differences between cameras and slow changes of the machine cancel. Ratios are averaged
// as logarithms, so that swapping the two times gives exactly the inverse.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/measure/bench_row.h"

namespace qs {

struct Interval {
  double low = 0, high = 0;
};

struct Ratio {
  double value = 1;
  std::optional<Interval> interval;  ///< 95 % confidence; unset for fewer than two samples
  std::size_t samples = 0;
};

/// The factor of the two-sided 95 % interval of Student's t distribution, degrees >= 1.
double student_t95(std::size_t degrees);

/// The geometric mean of at least one positive ratio, with the Student t interval of the mean of
/// their logarithms.
Ratio geometric_mean(std::span<const double> ratios);

/// Half of the interval, which must exist: the larger of its two sides.
double half_interval(const Ratio& ratio);

/// True if the measurement does not show a faster mode, because the interval contains 1.
bool is_undecided(const Ratio& ratio);

/// "2.03x \u00b10.06" with half_interval(), "1.02x \u00b10.05 noisy" if is_undecided(), "2.03x"
/// without an interval.
std::string ratio_text(const Ratio& ratio);

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

/// The sum of the frames of all rows; unset if a row lacks them.
std::optional<std::uint64_t> all_frames(std::span<const BenchRow* const> rows);

/// The geometric mean of the ratios of times at equal places of both lists. Unset without times.
std::optional<Ratio> ratio_of_times(std::span<const double> base_ms, std::span<const double> ms);

/// The ratio of two rows of one view, over the rounds that both have; if both have a single round,
/// over its frames. Unset without times.
std::optional<Ratio> paired_ratio(const BenchRow& base, const BenchRow& row);

/// For each scene, pipeline and mode except the baseline, in the order of the rows: the ratios of
/// the cameras, then their geometric mean. The mean over one camera is the ratio of that camera.
/// Views that lack the baseline are left out, and ratios of fewer than kFewestFrames frames.
std::vector<PairedRatio> paired_ratios(const std::vector<BenchRow>& rows,
                                       const std::string& baseline);

}  // namespace qs
