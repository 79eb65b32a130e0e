// SPDX-License-Identifier: MIT
//
// The track of a film's camera: around a subject, or along a path of keyframes.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "app/framing/whole_subject.h"
#include "app/measure/camera_path.h"

namespace qs {

/// The places where the camera slows down to a stop, besides keyframes with `eases`: nowhere, at
/// the film's begin and end, or at every keyframe.
enum class Ease { none, ends, all };

/// Index = Ease.
inline constexpr const char* kEaseNames[] = {"none", "ends", "all"};

struct CameraTrack {
  double seconds = 0;   ///< its own duration
  bool closed = false;  ///< it ends at its begin
  /// `share`: of the duration, 0 to 1; `size`: of the picture.
  std::function<Camera(double share, glm::ivec2 size)> at;
};

inline constexpr double kTurntableSeconds = 10;

/// Circles around the framing's target, at the height and distance of its eye: a full circle, or
/// from one end of the arc to the other and back, like a pendulum. A turntable has no keyframes:
/// Ease::all means Ease::ends. With `box`, which has the size of the subject, the framing is
/// whole_subject() for the size of the picture.
CameraTrack turntable(const Framing& framing, const Arc& arc, Ease ease,
                      const std::optional<SceneBox>& box = {});

/// The turntable of a scene: its whole subject, along the angles from which a camera has a free
/// view of it outside of fog, or along `arc`. `size`: of the pictures. The pool is used until it
/// returns.
struct TurntableWish {
  std::optional<Arc> arc;
  Ease ease = Ease::none;
  glm::ivec2 size{1280, 720};
};
CameraTrack turntable_of(const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                         const Framing& framing, const TurntableWish& wish, ThreadPool& pool);

/// Along the keyframes in their own times. At least two. `closed`: and back to the first keyframe,
/// see closed_path().
CameraTrack along(std::vector<Keyframe> keyframes, Ease ease, bool closed = false);

/// Camera `index` of `count` at equal time steps. The last camera is at the end of the track, or
/// one step before it if the track is closed, so that a film can be repeated.
Camera camera_of(const CameraTrack& track, int index, int count, glm::ivec2 size);

}  // namespace qs
