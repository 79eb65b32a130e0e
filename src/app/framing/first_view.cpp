// SPDX-License-Identifier: MIT
#include "app/framing/first_view.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <functional>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include "app/framing/camera_control.h"
#include "app/framing/candidate_views.h"
#include "app/framing/scene_box.h"
#include "app/framing/up_axis.h"
#include "raster/scene/place.h"

namespace qs {
namespace {

constexpr float kMostOfScene = 0.7f;  ///< a smaller subject has surroundings
constexpr int kAzimuths = 12;
constexpr double kElevations[] = {glm::radians(12.0), glm::radians(25.0), glm::radians(45.0)};
constexpr double kLiking[] = {0.8, 1.0, 0.2};  ///< the liking of each elevation
constexpr double kInsideFov = glm::radians(65.0);
constexpr double kFront = 10, kMostFront = 0.2;  ///< the preference for the front, in scores

struct Candidate {
  Framing framing;
  ViewQuality quality;
  double liking = 0;  ///< 0 to 1: preference for the direction
  double front = 0;   ///< preference for the front of an object, at most kMostFront
  double score = 0;   ///< set by rank()
};

float longest_side(const Subject& subject) { return largest_of(subject.box.size()); }

double azimuth_of(int index) { return index * 2 * glm::pi<double>() / kAzimuths; }
double liking_of(double azimuth) { return 0.5 + 0.5 * std::cos(azimuth); }

glm::dvec3 direction_of(const Framing& framing) {
  return glm::normalize(framing.target - framing.eye);
}

/// The cosine between the horizontal directions of two views with the same up direction.
double cos_around(const Framing& a, const Framing& b) {
  const auto level = [&](const Framing& framing) {
    const glm::dvec3 direction = direction_of(framing);
    return glm::normalize(direction - glm::dot(direction, a.up) * a.up);
  };
  return glm::dot(level(a), level(b));
}

/// The front of an object is the side with most details in hue: a face, labels, dials. A single
/// view is a bad measure of it, so all views are weighed by their directions.
void prefer_front(std::vector<Candidate>& candidates) {
  for (Candidate& candidate : candidates) {
    double front = 0, all = 1e-9;
    for (const Candidate& other : candidates) {
      front += other.quality.third_detail * cos_around(candidate.framing, other.framing);
      all += other.quality.third_detail;
    }
    candidate.front = std::clamp(kFront * front / all, -kMostFront, kMostFront);
  }
}

std::vector<Candidate> views_around(CandidateViews& views) {
  const Ground& ground = views.ground();
  const Shape& shape = views.shape();
  std::vector<Candidate> candidates;
  for (std::size_t e = 0; e < std::size(kElevations); ++e) {
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = azimuth_of(i);
      const glm::dvec3 toward_eye = std::sin(kElevations[e]) * ground.up -
                                    std::cos(kElevations[e]) * ground.direction(azimuth);
      const Framing framing = fit_view(shape, toward_eye, ground.up);
      const double distance = glm::distance(framing.eye, framing.target);
      const double free = std::max(distance - shape.radius, 0.3 * distance);
      candidates.push_back(
          {framing, views.measure(framing, free), 0.5 * kLiking[e] + 0.5 * liking_of(azimuth)});
    }
  }
  prefer_front(candidates);
  return candidates;
}

/// Views from near the border of the subject toward its middle.
std::vector<Candidate> views_inside(double eye_height, CandidateViews& views) {
  const Ground& ground = views.ground();
  constexpr double kMiddle = -0.2;  // a little below the middle of the height
  std::vector<Candidate> candidates;
  for (const double back : {0.8, 0.5}) {
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = azimuth_of(i);
      const glm::dvec2 toward(std::sin(azimuth), std::cos(azimuth));
      const glm::dvec2 border = toward / std::max(std::abs(toward.x), std::abs(toward.y));
      Framing framing;
      framing.eye = ground.position_of(-back * border, eye_height);
      framing.target = ground.position_of({0, 0}, ground.height.value_at(kMiddle));
      framing.up = ground.up;
      framing.vertical_fov = kInsideFov;
      const double distance = glm::distance(framing.eye, framing.target);
      framing.near_depth = std::min(0.2, 0.01 * distance);
      candidates.push_back({framing, views.measure(framing, 0.5 * distance), liking_of(azimuth)});
    }
  }
  return candidates;
}

/// Sorts the candidates, best first.
void rank(std::vector<Candidate>& candidates) {
  // A compromise between the subject's area in the picture and its area in the world, which is the
  // former times the squared distance. So a broad side is better than a narrow side seen from
  // nearer.
  const auto area_of = [](const Candidate& c) {
    const glm::dvec3 eye = framed_camera(c.framing, 16, 9).position();
    return c.quality.coverage * glm::distance(eye, c.framing.target);
  };
  double area = 1e-9, detail = 1e-9;
  for (const Candidate& c : candidates) {
    area = std::max(area, area_of(c));
    detail = std::max(detail, c.quality.detail);
  }
  for (Candidate& c : candidates)
    c.score = area_of(c) / area + c.quality.detail / detail + 2 * c.quality.shown - c.quality.cut +
              0.5 * c.liking + c.front - 3 * c.quality.obstruction - (c.quality.blocked ? 9 : 0);
  std::ranges::stable_sort(candidates, std::greater(), &Candidate::score);
}

/// The best view and different ones, as choose_framings() describes them.
std::vector<Framing> different_views(std::vector<Candidate> candidates, std::size_t most) {
  const double least_turn = std::cos(glm::radians(30.0)) + 1e-9;  // neighbours are 30 degrees apart
  const double other_side = std::cos(glm::radians(120.0)) + 1e-9;
  rank(candidates);
  std::vector<Framing> chosen = {candidates.front().framing};
  const auto try_all = [&](std::size_t limit, const auto& suits) {
    for (const Candidate& candidate : candidates) {
      const bool differs = std::ranges::all_of(chosen, [&](const Framing& other) {
        return glm::dot(direction_of(candidate.framing), direction_of(other)) <= least_turn;
      });
      if (chosen.size() < limit && differs && !candidate.quality.blocked &&
          suits(candidate.framing))
        chosen.push_back(candidate.framing);
    }
  };
  try_all(std::min<std::size_t>(most, 2), [&](const Framing& framing) {
    return cos_around(chosen.front(), framing) <= other_side;
  });
  try_all(most, [](const Framing&) { return true; });
  return chosen;
}

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

/// The height, along the ground's up, of an eye inside the subject: above its floor, with its
/// border all around. Empty for objects, which have no such place: other scenes are seen best from
/// inside, such as a room, a street, a place among trees.
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

}  // namespace

Camera framed_camera(const Framing& framing, int width, int height) {
  const double aspect = static_cast<double>(width) / height;
  const double farther =
      std::clamp(framing.aspect / aspect, 1.0, framing.farthest * std::max(1.0, 1 / aspect));
  const glm::dvec3 eye = framing.target + farther * (framing.eye - framing.target);
  Camera camera = look_at(eye, framing.target, framing.up, framing.vertical_fov, width, height);
  camera.near_depth = framing.near_depth;
  return camera;
}

Framing choose_framing(const GaussianCloud& cloud, const std::optional<glm::dvec3>& up,
                       ThreadPool& pool) {
  return choose_framings(cloud, up, pool, 1).front();
}

std::vector<Framing> choose_framings(const GaussianCloud& cloud,
                                     const std::optional<glm::dvec3>& up, ThreadPool& pool,
                                     std::size_t most) {
  return choose_framings(sample_of(cloud, Sampling().most), up, pool, most);
}

std::vector<Framing> choose_framings(const CloudSample& sample, const std::optional<glm::dvec3>& up,
                                     ThreadPool& pool, std::size_t most) {
  const Subject whole = find_subject(sample, kSceneDensity);
  const UpEstimate upward =
      up ? UpEstimate{*up, false, true} : estimate_up(sample, whole, {0, -1, 0});
  const auto chosen = [&](std::vector<Candidate> candidates) {
    std::vector<Framing> framings = different_views(std::move(candidates), most);
    for (Framing& framing : framings) {
      framing.upside_down = upward.upside_down;
      framing.up_is_assumed = !upward.has_floor;
    }
    return framings;
  };
  const Ground ground(whole, upward.up);
  CandidateViews whole_views(sample, whole, ground, pool);
  if (const auto height = eye_height_inside(whole_views))
    return chosen(views_inside(*height, whole_views));
  const Subject dense = find_subject(sample, kSubjectDensity);
  const bool is_whole = longest_side(dense) >= kMostOfScene * longest_side(whole);
  CandidateViews views(sample, is_whole ? whole : dense, ground, pool, ThirdChannel::hue);
  return chosen(views_around(views));
}

std::optional<glm::dvec3> declared_up(const std::optional<glm::dvec3>& given,
                                      const std::string& vertical_axis) {
  if (given || vertical_axis.empty()) return given;
  return world_up(vertical_axis);
}

glm::dvec3 cameras_up(const std::vector<Camera>& cameras, glm::dvec3 otherwise) {
  const auto count = static_cast<double>(cameras.size());
  glm::dvec3 sum(0);
  glm::dmat3 rights(0);
  for (const Camera& camera : cameras) {
    const ViewAxes axes = view_axes(camera);
    sum -= axes.down;
    rights += glm::outerProduct(axes.right, axes.right);
  }
  const double length = glm::length(sum);
  if (!(length > 0.1 * count)) return otherwise;
  const glm::dvec3 mean = sum / length;
  const PrincipalAxes axes = principal_axes(rights);
  const double side = glm::dot(axes.axis[0], mean);
  const bool determined = axes.value[0] < 0.1 * axes.value[1] && axes.value[1] > 0.005 * count;
  if (!determined || std::abs(side) < 0.5) return mean;
  return side < 0 ? -axes.axis[0] : axes.axis[0];
}

std::optional<glm::dvec3> cameras_target(const std::vector<Camera>& cameras) {
  glm::dmat3 across(0);
  glm::dvec3 sum(0);
  for (const Camera& camera : cameras) {
    const glm::dvec3 forward = view_axes(camera).forward;
    const glm::dmat3 one = glm::dmat3(1.0) - glm::outerProduct(forward, forward);
    across += one;
    sum += one * camera.position();
  }
  const PrincipalAxes axes = principal_axes(across);
  if (cameras.empty() || !(axes.value[0] > 0.002 * axes.value[2])) return {};
  const glm::dvec3 target = glm::inverse(across) * sum;
  const auto ahead = std::ranges::count_if(
      cameras, [&](const Camera& camera) { return depth_of(camera, target) > 0; });
  if (2 * ahead < static_cast<std::ptrdiff_t>(cameras.size())) return {};
  return target;
}

std::optional<Framing> framing_of(const std::vector<Camera>& all, glm::dvec3 up) {
  const std::vector<Camera> cameras = without_outliers(all);
  if (cameras.empty()) return {};
  glm::dvec3 middle(0);
  for (const Camera& camera : cameras)
    middle += camera.position() / static_cast<double>(cameras.size());
  const std::optional<glm::dvec3> target = cameras_target(cameras);
  std::vector<double> distances;
  for (const Camera& camera : cameras)
    distances.push_back(glm::distance(camera.position(), target.value_or(middle)));
  const double usual = upper_median(std::move(distances));  // distance of a camera
  // With a target: the camera that looks straightest at it from about the usual distance. Without a
  // target: the camera nearest to the middle of all cameras.
  std::optional<Framing> best;
  double least = 0;
  for (const Camera& camera : cameras) {
    const glm::dvec3 eye = camera.position(), forward = view_axes(camera).forward;
    const glm::dvec3 seen = target ? *target : eye + std::max(usual, 1e-3) * forward;
    const double distance = glm::distance(seen, eye);
    if (!(distance > 1e-3 * usual) || std::abs(glm::dot(seen - eye, up)) > 0.98 * distance)
      continue;
    const double straight = glm::dot(forward, seen - eye) / distance;
    const double cost = target ? std::abs(std::log(distance / usual)) + 2 * (1 - straight)
                               : glm::distance(eye, middle);
    if (best && cost >= least) continue;
    least = cost;
    best = Framing{eye, seen, up, vertical_fov(camera), 0, 1, camera.near_depth};
  }
  return best;
}

Framing subject_framing(const std::vector<Camera>& cameras, const std::optional<glm::dvec3>& up,
                        const std::function<Framing()>& choose) {
  const glm::dvec3 upward = up.value_or(cameras_up(cameras, world_up("")));
  const std::optional<Framing> framing = framing_of(cameras, upward);
  return framing ? *framing : choose();
}

}  // namespace qs
