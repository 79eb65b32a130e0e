// SPDX-License-Identifier: MIT
#include "app/framing/whole_subject.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/trigonometric.hpp>

#include "app/framing/camera_control.h"
#include "app/framing/candidate_views.h"
#include "app/framing/subject.h"

namespace qs {
namespace {

constexpr double kTurn = 2 * glm::pi<double>(), kLargestGap = 0.25 * kTurn;
constexpr double kArcMargin =
    0.1;  ///< share of an arc that is cut off at each end, which few cameras saw
constexpr double kAsFar = 0.75;  ///< share of the eye's distance: nearer cameras may face a wall

constexpr int kArcSteps = 48;   ///< all around
constexpr double kNear = 0.45;  ///< share of the eye's distance: nearer Gaussians can hide it
/// mean change of the picture without these Gaussians, above which they hide the subject
constexpr double kHidden = 0.05;

constexpr double kWidestFov = glm::radians(75.0);

bool holds(const SceneBox& box, glm::dvec3 point) {
  return glm::clamp(point, glm::dvec3(box.low), glm::dvec3(box.high)) == point;
}

std::array<glm::dvec3, 8> corners_of(const SceneBox& box) {
  std::array<glm::dvec3, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners[i] = glm::dvec3(i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                            i & 4 ? box.high.z : box.low.z);
  return corners;
}

// The tangent of half the vertical field of view that shows all corners from all angles of the arc;
// infinite if a corner is not in front of the eye.
double needed_slope(const Framing& framing, const SceneBox& box, const Arc& arc, double aspect) {
  constexpr int kAngles = 72;
  double slope = 0;
  const Camera camera = look_at(framing.eye, framing.target, framing.up, 1, 16, 16);
  for (int i = 0; i <= kAngles; ++i) {
    const double angle = arc.low + (arc.high - arc.low) * i / kAngles;
    const Camera turned = orbited(camera, framing.target, framing.up, angle, 0);
    for (const glm::dvec3& corner : corners_of(box)) {
      const glm::dvec3 at = turned.view_from_world * glm::dvec4(corner, 1);
      if (at.z <= 0) return std::numeric_limits<double>::infinity();
      slope = std::max({slope, std::abs(at.y) / at.z, std::abs(at.x) / (at.z * aspect)});
    }
  }
  return slope / kWholeShare;
}

}  // namespace

bool Arc::whole() const { return high - low >= kTurn - 1e-9; }

Arc arc_of(double degrees) {
  const double half = 0.5 * glm::radians(std::min(degrees, 360.0));
  return {-half, half};
}

Arc seen_arc(const std::vector<Camera>& cameras, const Framing& framing) {
  const auto across = [&](glm::dvec3 v) { return v - glm::dot(v, framing.up) * framing.up; };
  const glm::dvec3 ahead = across(framing.eye - framing.target);
  const glm::dvec3 left = glm::cross(ahead, framing.up);
  std::vector<double> angles = {0};
  for (const Camera& camera : cameras) {
    const glm::dvec3 at = camera.position() - framing.target;
    if (glm::length(at) < kAsFar * glm::distance(framing.eye, framing.target)) continue;
    angles.push_back(std::atan2(glm::dot(at, left), glm::dot(at, ahead)));
  }
  std::sort(angles.begin(), angles.end());
  // The arc is the circle without its largest gap.
  double gap = angles.front() + kTurn - angles.back();
  Arc arc{angles.front(), angles.back()};
  for (std::size_t i = 1; i < angles.size(); ++i) {
    if (angles[i] - angles[i - 1] <= gap) continue;
    gap = angles[i] - angles[i - 1];
    arc = {angles[i], angles[i - 1] + kTurn};
  }
  if (gap <= kLargestGap) return arc_of(360);
  if (arc.low > 0) arc = {arc.low - kTurn, arc.high - kTurn};
  const double margin = kArcMargin * (arc.high - arc.low);
  return {std::min(arc.low + margin, 0.0), std::max(arc.high - margin, 0.0)};
}

Arc open_arc(const GaussianCloud& cloud, const Framing& framing, ThreadPool& pool) {
  const CloudSample sample = sample_of(cloud, Sampling().most);
  const Subject subject = find_subject(sample, kSubjectDensity);
  const Ground ground(subject, framing.up);
  CandidateViews views(sample, subject, ground, pool);
  const double free = kNear * glm::distance(framing.eye, framing.target);
  const auto obstruction = [&](int direction) {
    const Camera start = framed_camera(framing, 16, 9);
    const double angle = kTurn * direction / kArcSteps;
    Framing turned = framing;
    turned.eye = orbited(start, framing.target, framing.up, angle, 0).position();
    const ViewQuality view = views.measure(turned, free);
    return view.blocked ? 1 : view.obstruction;
  };
  const double most = obstruction(0) + kHidden;
  int left = 0, right = 0;
  while (left < kArcSteps && obstruction(left + 1) < most) ++left;
  if (left == kArcSteps) return arc_of(360);
  while (obstruction(-right - 1) < most) ++right;
  return {-kTurn * right / kArcSteps, kTurn * left / kArcSteps};
}

Arc free_arc(const std::vector<Camera>& cameras, const GaussianCloud& cloud, const Framing& framing,
             ThreadPool& pool) {
  return cameras.empty() ? open_arc(cloud, framing, pool) : seen_arc(cameras, framing);
}

SceneBox subject_box(const GaussianCloud& cloud) {
  return find_subject(sample_of(cloud, Sampling().most), kSubjectDensity).box;
}

Framing whole_subject(const Framing& framing, const SceneBox& box, const Arc& arc, double aspect) {
  if (holds(box, framing.eye)) return framing;
  Framing whole = framing;
  const glm::dvec3 toward_eye = framing.eye - framing.target;
  whole.target = glm::dvec3(box.center());
  whole.eye = whole.target + toward_eye;
  whole.aspect = 0;  // the picture's shape is accounted for here
  const double widest = std::tan(0.5 * kWidestFov);
  double farther = 1;
  while (needed_slope(whole, box, arc, aspect) > widest) {
    constexpr double kStep = 1.02;
    farther *= kStep;
    whole.eye = whole.target + farther * toward_eye;
  }
  const double slope = needed_slope(whole, box, arc, aspect);
  whole.vertical_fov = std::max(2 * std::atan(slope), std::min(framing.vertical_fov, kWidestFov));
  return whole;
}

namespace {

constexpr float kFogReach = 3;  // standard deviations; alpha is below 0.012 beyond

float fog_radius(const GaussianCloud& cloud, std::size_t i) {
  return kFogReach * std::exp(largest_of(cloud.log_scales[i]));
}

bool is_in_fog_of(const GaussianCloud& cloud, std::size_t i, const glm::vec3& at) {
  constexpr float kFog = 0.1f;
  const glm::vec3 from = at - cloud.positions[i];
  const float reach = fog_radius(cloud, i);
  if (!(glm::dot(from, from) < reach * reach)) return false;
  const glm::vec3 deviations =
      glm::conjugate(cloud.rotations[i]) * from / glm::exp(cloud.log_scales[i]);
  const float opacity = 1 / (1 + std::exp(-cloud.opacity_logits[i]));
  return opacity * std::exp(-0.5f * glm::dot(deviations, deviations)) > kFog;
}

// The Gaussians that reach the sphere on which the eye turns.
std::vector<std::size_t> near_eyes(const GaussianCloud& cloud, const Framing& framing) {
  const glm::vec3 target(framing.target);
  const auto radius = static_cast<float>(glm::distance(framing.eye, framing.target));
  const float rounding = 1e-3f * radius;
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float from_sphere = std::abs(glm::distance(cloud.positions[i], target) - radius);
    if (from_sphere < fog_radius(cloud, i) + rounding) near.push_back(i);
  }
  return near;
}

}  // namespace

bool is_in_fog(const GaussianCloud& cloud, glm::dvec3 point) {
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (is_in_fog_of(cloud, i, glm::vec3(point))) return true;
  return false;
}

Arc clear_arc(const Arc& arc, const Framing& framing, const GaussianCloud& cloud) {
  constexpr double kStep = glm::radians(2.5);
  const Camera camera = look_at(framing.eye, framing.target, framing.up, 1, 16, 16);
  const std::vector<std::size_t> near = near_eyes(cloud, framing);
  const auto clear = [&](double angle) {
    const glm::vec3 eye(orbited(camera, framing.target, framing.up, angle, 0).position());
    return std::ranges::none_of(near, [&](std::size_t i) { return is_in_fog_of(cloud, i, eye); });
  };
  if (!clear(0)) return arc;
  Arc result;
  while (result.high < arc.high && clear(std::min(result.high + kStep, arc.high)))
    result.high = std::min(result.high + kStep, arc.high);
  while (result.low > arc.low && clear(std::max(result.low - kStep, arc.low)))
    result.low = std::max(result.low - kStep, arc.low);
  return result;
}

}  // namespace qs
