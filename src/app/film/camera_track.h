// SPDX-License-Identifier: MIT
//
// How the camera of a film moves: round a subject, or along a path of keyframes.
#pragma once

#include <functional>
#include <vector>

#include "app/framing/free_arc.h"
#include "app/measure/camera_path.h"

namespace qs {

/// Where the camera slows down to a stop, besides the keyframes that say so themselves: nowhere,
/// where the film begins and ends, or at every keyframe.
enum class Ease { none, ends, all };

/// Index = Ease.
inline constexpr const char* kEaseNames[] = {"none", "ends", "all"};

struct CameraTrack {
  double seconds = 0;   ///< its own duration
  bool closed = false;  ///< it ends where it begins
  /// `share`: of the duration, 0 to 1; `size`: of the picture.
  std::function<Camera(double share, glm::ivec2 size)> at;
};

inline constexpr double kTurntableSeconds = 10;

/// Round what a framing shows, from its own eye and at its height: all the way round, or from one
/// end of the arc to the other and back, like a pendulum. A turntable has no keyframes: Ease::all
/// means Ease::ends.
CameraTrack turntable(const Framing& framing, const Arc& arc, Ease ease);

/// Along the keyframes in their own times. At least two.
CameraTrack along(std::vector<Keyframe> keyframes, Ease ease);

/// The same, and back to the first keyframe: see closed_path().
CameraTrack along_and_back(std::vector<Keyframe> keyframes, Ease ease);

/// Camera `index` of `count` at equal time steps. The last one is at the end of the track, or one
/// step before it if the track is closed, so that a film can be repeated.
Camera camera_of(const CameraTrack& track, int index, int count, glm::ivec2 size);

}  // namespace qs
