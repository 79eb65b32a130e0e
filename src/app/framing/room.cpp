// SPDX-License-Identifier: MIT
#include "app/framing/room.h"

#include <bitset>
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <glm/trigonometric.hpp>

#include "app/framing/camera_control.h"

namespace qs {
namespace {

constexpr double kLeastClosed = 0.85, kLeastFloor = 0.65;

/// The share of the horizon around a place, 0 to 1, that the border of the subject closes.
double closed_share(glm::dvec3 eye, CandidateViews& views) {
  const Ground& ground = views.ground();
  double sum = 0;
  for (int side = 0; side < 4; ++side) {
    const glm::dvec3 target = eye + ground.direction(side * glm::half_pi<double>());
    Camera camera = look_at(eye, target, ground.up, glm::radians(40.0), 64, 23);  // 90 degrees wide
    camera.near_depth = 1e-3 * (ground.ahead.high - ground.ahead.low);
    sum += views.border_share(camera) / 4;
  }
  return sum;
}

/// The share of the ground under the subject, 0 to 1, that Gaussians at its lower border cover.
double floor_share(const GaussianCloud& sample, const Ground& ground) {
  constexpr int kSide = 10;
  constexpr double kThickness = 0.15;  // as a share of half the height
  std::bitset<kSide * kSide> covered;
  for (const glm::vec3& each : sample.positions) {
    const glm::dvec3 position(each);
    if (std::abs(ground.height.place_of(glm::dot(ground.up, position)) + 1) > kThickness) continue;
    const glm::dvec2 at = 0.5 * kSide * (ground.place_of(position) + 1.0);
    if (at.x >= 0 && at.x < kSide && at.y >= 0 && at.y < kSide)
      covered.set(static_cast<std::size_t>(int(at.y) * kSide + int(at.x)));
  }
  return static_cast<double>(covered.count()) / (kSide * kSide);
}

}  // namespace

std::optional<double> eye_height_inside(CandidateViews& views) {
  const Ground& ground = views.ground();
  if (floor_share(views.gaussians(), ground) < kLeastFloor) return {};
  for (const double share : {0.55, 0.8, 1.05}) {
    const double height = ground.height.value_at(2 * share - 1);
    for (const glm::dvec2 place : {glm::dvec2(0, 0), glm::dvec2(0, -0.5), glm::dvec2(0, 0.5),
                                   glm::dvec2(-0.5, 0), glm::dvec2(0.5, 0)}) {
      const glm::dvec3 eye = ground.position_of(place, height);
      if (!views.is_inside_a_gaussian(eye) && closed_share(eye, views) >= kLeastClosed)
        return height;
    }
  }
  return {};
}

}  // namespace qs
