// SPDX-License-Identifier: MIT
//
// The numbers of the culling modes that come with the frames: their counts and their times.
//
// Frames count the tile pairs of all modes beside drawing (Outputs::mode_pairs), always for the
// full size of the picture, so a count is exact even where the frame in the window is reduced.
// While the camera moves some frames may not count.
//
// FPS come from times of single frames until the modes are measured, and while the camera moves.
// Frames of different views or sizes do not compare, so the render thread draws another mode at the
// very view and size of a picture in the window, one mode after the other. The FPS of a mode are
// the FPS of the pictures of the last second, times the median ratio of the mode's last pairs. So
// all rows of the table share size and moment. Texts mark such numbers with "~".
#pragma once

#include <optional>
#include <string>

#include "app/viewer/state/viewer.h"

namespace qs {

/// A row has FPS in flight once this many pairs of its size were drawn.
inline constexpr std::size_t kPairsOfMode = 5;

/// Seconds of pictures behind the FPS of the mode in use. Older ratios say their age.
inline constexpr double kLiveSeconds = 1;

/// The FPS of a mode in the views of the last second.
struct LiveRate {
  double fps = 0;
  double age = 0;  ///< seconds since the last pair; 0 for the mode in use and for a view at rest
};

/// At the size of the picture in the window; unset until there are enough frames of the mode with
/// the pipeline and the backend in use.
std::optional<LiveRate> live_rate(const Viewer& viewer, CullMode mode,
                                  std::size_t fewest = kPairsOfMode);

/// "~310", or "~310 (4 s)" for a rate of that age.
std::string live_text(const LiveRate& rate);

/// The size at which the frame was drawn, pixels.
glm::ivec2 drawn_size(const ShownFrame& frame);

/// " at 1/2" behind a number of a frame of half the size along each side; empty for the full size.
std::string size_text(int divisor);

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

/// "5,000", or "~5,000" for a count of an earlier view.
std::string count_text(const LiveCount& count);

/// The camera of the counts: the picture's own while it moves, else measured_camera().
Camera counted_camera(const Viewer& viewer);

/// Width and height of the camera's pictures, pixels.
glm::ivec2 size_of(const Camera& camera);

/// The count of a mode; unset if it is unknown or of another size than counted_camera(), and for
/// other modes than 1..culler_count().
std::optional<LiveCount> live_pairs(const Viewer& viewer, CullMode mode);

/// True if the table of modes, the badge or a change of the mode is visible, so that frames count.
bool shows_counts(const Viewer& viewer);

/// True if the counts are of the view of the next frame.
bool counts_are_current(const Viewer& viewer);

namespace action {

/// A frame that was drawn for its time alone.
void frame_paired(Viewer& viewer, const PairedFrame& pair);

/// Takes the time and the pairs of a new frame; Viewer::shown is still the frame before it.
void learn_from_frame(Viewer& viewer, const ShownFrame& frame);

/// Forgets everything of the scene.
void forget_live_times(Viewer& viewer);

}  // namespace action
}  // namespace qs
