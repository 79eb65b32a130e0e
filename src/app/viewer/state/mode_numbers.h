// SPDX-License-Identifier: MIT
//
// The reliability of the numbers in the table of modes, and the decision that enough frames were
// measured. One frame of every mode makes a round, so round i of two modes can be compared.
#pragma once

#include <cstddef>
#include <optional>

#include "app/measure/paired_ratios.h"
#include "app/measure/statistics.h"
#include "app/viewer/state/viewer.h"

namespace qs {

inline constexpr std::size_t kEnoughFrames = 100;  ///< even if intervals are still large
inline constexpr double kMostMeasuringMs = 20000;  ///< of frames for one view
inline constexpr double kSmallInterval = 0.02;  ///< half of the interval of a ratio, of the ratio

/// The numbers of a mode in a pipeline; null if it was not measured.
const BenchRow* measured_row(const Viewer& viewer, CullMode mode, Pipeline pipeline);

/// A size of kMeasuredSizes in the view in the window; 0: the view has none, and the picture's
/// size is used.
glm::ivec2 measured_size(const Viewer& viewer, std::size_t index);

/// The view in the window at the size at which all modes are measured.
Camera measured_camera(const Viewer& viewer);

/// True if the numbers are of the view in the window. False for numbers of an earlier view, and
/// while a zoom is recorded.
bool numbers_are_current(const Viewer& viewer);

/// True if this view needs no more frames: all ratios have a small interval, or the limit of frames
/// or of time is reached.
bool numbers_suffice(const Viewer& viewer);

/// Adds the frames of `added` to `row`. Both are of the same mode and view.
void add_frames(BenchRow& row, const BenchRow& added);

/// The smallest number of frames behind the rows of a table.
std::size_t frames_behind(const ModeNumbers& numbers);

/// The ratio of Viewer::baseline to the row; unset if one of them was not measured.
std::optional<Ratio> ratio_to_baseline(const Viewer& viewer, const BenchRow* row,
                                       Pipeline pipeline);

}  // namespace qs
