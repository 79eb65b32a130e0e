// SPDX-License-Identifier: MIT
#include "app/framing/free_arc.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/trigonometric.hpp>

#include "app/framing/camera_control.h"
#include "app/framing/candidate_views.h"

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

}  // namespace qs
