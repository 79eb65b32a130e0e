// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "app/framing/camera_control.h"
#include "app/framing/depth_ahead.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"

namespace qs {
namespace {

constexpr double kDistancesPerSecond = 0.5;  ///< speed over the distance ahead
constexpr double kSideways = 0.5;  ///< the same speed would move what is near out of the picture
constexpr double kMostOfDistance = 0.5;  ///< from one picture to the next
constexpr double kFasterPerNotch = 1.2, kMostFactor = 100;
constexpr double kAccelerationSeconds = 0.12;  ///< to reach 63 % of a new velocity
constexpr double kDistanceSeconds = 0.4;       ///< the same for the distance ahead
constexpr double kStillShare = 0.01;           ///< of the speed: slower motion counts as rest
constexpr double kTravelSeconds = 0.35;

// The part of the way that a first-order lag covers in `seconds`, 0 to 1.
double approach(double seconds, double constant) { return 1 - std::exp(-seconds / constant); }

double distance_ahead(const Viewer& v) {
  const double least = 1e-3 * v.scene->extent();
  const auto measured = depth_ahead(v.camera, v.scene->landmarks);
  return std::max(measured.value_or(0.5 * v.scene->extent()), least);
}

// The distance changes slowly, so that passing a near object does not stop the flight.
void update_distance(Viewer& v, double seconds) {
  const double now = distance_ahead(v);
  double& kept = v.flight.distance;
  if (!(kept > 0)) kept = now;
  kept *= std::pow(now / kept, approach(seconds, kDistanceSeconds));
}

}  // namespace

double flying_speed(const Viewer& v) {
  if (!v.scene) return 0;
  const double distance = v.flight.distance > 0 ? v.flight.distance : distance_ahead(v);
  return kDistancesPerSecond * distance * v.flight.factor;
}

void action::fly(Viewer& v, glm::dvec3 direction, double factor) {
  if (!v.scene) return;
  v.hints.fly = false;
  v.flight.wish = factor * glm::dvec3(kSideways, 1, 1) * direction;
  v.last_motion = v.now;
}

void action::turn_wheel(Viewer& v, double notches) {
  if (v.navigation == Navigation::orbit) return dolly(v, notches);
  v.flight.factor = std::clamp(v.flight.factor * std::pow(kFasterPerNotch, notches),
                               1 / kMostFactor, kMostFactor);
}

void action::travel_to(Viewer& v, const Camera& camera, int dataset_camera) {
  const Camera to = v.camera.width > 0 ? camera.resized(v.camera.width, v.camera.height) : camera;
  v.flight.velocity = {};
  v.view_choice = {};
  v.travel = Travel{v.camera, to, 0, dataset_camera};
  if (!v.animates_moves || !v.scene) return arrive(v);
  v.last_motion = v.now;
}

void action::arrive(Viewer& v) {
  if (!v.travel) return;
  v.camera = v.travel->to;
  v.dataset_camera = v.travel->dataset_camera;
  v.travel.reset();
  complete_move(v);
  view_changed(v);
}

void action::advance_motion(Viewer& v, double seconds) {
  if (!v.scene) return;
  if (v.travel) {
    Travel& travel = *v.travel;
    travel.seconds += seconds;
    v.last_motion = v.now;
    const double share = travel.seconds / kTravelSeconds;
    if (share >= 1) return arrive(v);
    const double eased = share * share * (3 - 2 * share);
    v.camera = camera_at({{0, travel.from}, {1, travel.to}}, eased);
    v.dataset_camera = -1;
    view_changed(v);
    return;
  }
  Flight& flight = v.flight;
  const bool flies = flight.wish != glm::dvec3(0);
  if (!flies && flight.velocity == glm::dvec3(0)) {
    flight.distance = 0;
    return;
  }
  update_distance(v, seconds);
  const double speed = flying_speed(v);
  flight.velocity +=
      (speed * flight.wish - flight.velocity) * approach(seconds, kAccelerationSeconds);
  flight.wish = {};
  if (!flies && glm::length(flight.velocity) < kStillShare * speed) flight.velocity = {};
  // Pictures that take long show the subject before the camera has passed it.
  if (std::exchange(flight.frame, v.frames) != v.frames)
    flight.room = kMostOfDistance * flight.distance;
  glm::dvec3 step = seconds * flight.velocity;
  const double length = glm::length(step);
  if (length > flight.room) step *= flight.room / length;
  flight.room -= std::min(length, flight.room);
  shift(v, step);
}

}  // namespace qs
