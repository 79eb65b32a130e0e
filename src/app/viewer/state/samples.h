// SPDX-License-Identifier: MIT
//
// The numbers of the culling modes that come with the frames: their counts and their times.
//
// Frames count the tile pairs of all modes beside drawing (Outputs::mode_pairs), always for the
// full size of the picture, so a count is exact even where the frame in the window is reduced.
// While the camera moves some frames may not count.
//
// Times of single frames are samples. A sample is less than a measurement, but it comes at once,
// and also while the camera moves: frames in the window give samples of their mode, and the render
// thread draws frames of the other modes in turns. Texts mark samples with "~".
#pragma once

#include <optional>
#include <string>

#include "app/viewer/state/viewer.h"

namespace qs {

/// A sample is forgotten if more frames of other views than this were shown after it.
inline constexpr int kMostFramesOfSample = 100;

/// The sample of a mode with the pipeline and the backend in use; null if there is none of this
/// view or of a recent view.
const ModeSample* sample_of(const Viewer& viewer, CullMode mode);

/// FPS of the sample, without regard to its size.
double fps_of(const ModeSample& sample);

/// "~310", or "~52 at 1/2" for a frame of half the size along each side.
std::string sample_text(const ModeSample& sample);

/// " at 1/2" behind a number of a frame of half the size along each side; empty for the full size.
std::string size_text(int divisor);

/// Two significant digits, because one frame gives no more: 312.5 is "310", 0.834 is "0.83".
std::string rough(double value);

/// The tile pairs of the frame in the window at its full size.
struct FullSizePairs {
  std::uint64_t pairs = 0;
  bool exact = true;  ///< else an estimate from a reduced frame
};

/// Unset for a reduced frame if no frame of this scene was seen reduced and at full size.
std::optional<FullSizePairs> full_size_pairs(const Viewer& viewer);

/// True if the time of the frame is the time of its mode alone: it has no map and no second frame.
bool shows_colors_alone(const ShownFrame& frame);

/// A count is unknown if more frames of other views than this were shown after it.
inline constexpr int kMostFramesAgo = 10;

/// The size of a mode's own frame.
struct LiveCount {
  std::uint64_t tile_pairs = 0;
  std::uint32_t visible = 0;
  /// 0: exact for the view in the window; else of the view that many frames ago
  int frames_ago = 0;
};

/// The count of a mode; unset if it is unknown, and for other modes than 1..culler_count().
std::optional<LiveCount> live_pairs(const Viewer& viewer, CullMode mode);

/// True if the table of modes is visible, so that frames count.
bool shows_counts(const Viewer& viewer);

/// True if the counts are of the view of the next frame.
bool counts_are_current(const Viewer& viewer);

namespace action {

/// A frame that was drawn for the table alone.
void mode_sampled(Viewer& viewer, const ModeSample& sample);

/// Takes the sample and the pairs of a new frame; Viewer::shown is still the frame before it.
void learn_from_frame(Viewer& viewer, const ShownFrame& frame);

/// Forgets everything of the scene.
void forget_samples(Viewer& viewer);

}  // namespace action
}  // namespace qs
