// SPDX-License-Identifier: MIT
#include "app/film/camera_track.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <glm/gtc/constants.hpp>

#include "app/framing/camera_control.h"

namespace qs {
namespace {

constexpr double kTurn = 2 * glm::pi<double>();

// Begins and ends with speed 0.
double eased(double share) { return share * share * (3 - 2 * share); }

}  // namespace

CameraTrack turntable(const Framing& framing, const Arc& arc, Ease ease,
                      const std::optional<SceneBox>& box) {
  const double middle = 0.5 * (arc.low + arc.high), half = 0.5 * (arc.high - arc.low);
  const double phase = half > 0 ? std::asin(std::clamp(-middle / half, -1.0, 1.0)) : 0;
  return {kTurntableSeconds, true, [=](double share, glm::ivec2 size) {
            const double turn = kTurn * (ease == Ease::none ? share : eased(share));
            const double angle = arc.whole() ? turn : middle + half * std::sin(phase + turn);
            const double aspect = static_cast<double>(size.x) / size.y;
            const Framing shown = box ? whole_subject(framing, *box, arc, aspect) : framing;
            const Camera camera = framed_camera(shown, size.x, size.y);
            return orbited(camera, shown.target, shown.up, angle, 0);
          }};
}

CameraTrack turntable_of(const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                         const Framing& framing, const TurntableWish& wish, ThreadPool& pool) {
  const SceneBox box = subject_box(cloud);
  if (wish.arc) return turntable(framing, *wish.arc, wish.ease, box);
  const Arc free = free_arc(cameras, cloud, framing, pool);
  const double aspect = static_cast<double>(wish.size.x) / wish.size.y;
  const Arc arc = clear_arc(free, whole_subject(framing, box, free, aspect), cloud);
  return turntable(framing, arc, wish.ease, box);
}

CameraTrack along(std::vector<Keyframe> keyframes, Ease ease, bool closed) {
  for (Keyframe& keyframe : keyframes) keyframe.eases = keyframe.eases || ease == Ease::all;
  if (ease == Ease::ends) keyframes.front().eases = true;
  if (ease == Ease::ends && !closed) keyframes.back().eases = true;
  const double begin = keyframes.front().time;
  const double seconds = closed ? closed_length(keyframes) : keyframes.back().time - begin;
  const auto path = std::make_shared<const std::vector<Keyframe>>(closed ? closed_path(keyframes)
                                                                         : std::move(keyframes));
  return {seconds, closed, [=](double share, glm::ivec2 size) {
            return camera_at(*path, begin + share * seconds).resized(size.x, size.y);
          }};
}

Camera camera_of(const CameraTrack& track, int index, int count, glm::ivec2 size) {
  const int steps = std::max(track.closed ? count : count - 1, 1);
  return track.at(static_cast<double>(index) / steps, size);
}

}  // namespace qs
