// SPDX-License-Identifier: MIT
#include "app/framing/candidate_views.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>

#include "app/framing/scene_box.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

constexpr std::size_t kMostPoints = 400;
constexpr double kFilled = 0.72, kLeastFilled = 0.5;  ///< share of the height that the box fills
constexpr double kLeastDense = 0.47;  ///< share that the middle 90 % of the points fill
constexpr double kShown = 0.95;       ///< the middle 98 % fill at most this share
constexpr double kMostOff = 0.06;     ///< largest offset of the box's middle, in heights
constexpr double kLine = 4;           ///< a shape so much wider than high shows its whole width

/// A rectangle in the picture, in heights of the picture from its centre.
struct Rectangle {
  glm::dvec2 low{1e9}, high{-1e9};
  glm::dvec2 center() const { return 0.5 * (low + high); }
  double height() const { return std::max(high.y - low.y, 1e-3); }  // flat shapes seen edge-on
};

/// The extents of a shape in the picture.
struct ScreenExtents {
  Rectangle box;            ///< its corners
  Rectangle dense, nearly;  ///< the middle 90 % and 98 % of its points
};

/// The eye and axes from which fit_view() makes a camera.
struct Viewpoint {
  glm::dvec3 right, down, forward, eye;
  double nearest;  ///< smallest depth; nearer points and points behind the eye get it

  glm::dvec2 project(glm::dvec3 point) const {
    const glm::dvec3 from = point - eye;
    const double depth = std::max(glm::dot(from, forward), nearest);
    return glm::dvec2(glm::dot(from, right), glm::dot(from, down)) /
           (2 * std::tan(0.5 * kVerticalFov) * depth);
  }
};

ScreenExtents extents_of(const Shape& shape, const Viewpoint& viewpoint) {
  ScreenExtents extents;
  for (const glm::dvec3& corner : shape.corners) {
    const glm::dvec2 at = viewpoint.project(corner);
    extents.box.low = glm::min(extents.box.low, at);
    extents.box.high = glm::max(extents.box.high, at);
  }
  std::vector<double> values(shape.points.size());
  for (int axis = 0; axis < 2; ++axis) {
    std::transform(shape.points.begin(), shape.points.end(), values.begin(),
                   [&](glm::dvec3 point) { return viewpoint.project(point)[axis]; });
    const Quantiles quantiles(values, shape.weights);
    extents.dense.low[axis] = quantiles.at(0.05);
    extents.dense.high[axis] = quantiles.at(0.95);
    extents.nearly.low[axis] = quantiles.at(0.01);
    extents.nearly.high[axis] = quantiles.at(0.99);
  }
  return extents;
}

constexpr int kWidth = 64, kHeight = 36;
constexpr std::size_t kMostDrawn = 12'000;
constexpr float kVisible = 0.1f;  ///< opacity
enum Channel { kBrightness, kSubject, kThird };

// Every n-th Gaussian of the sample, with the colour channels as named above.
GaussianCloud coded(const GaussianCloud& sample, const Subject& subject, const Ground& ground,
                    ThirdChannel third) {
  const std::size_t count = std::min(sample.size(), kMostDrawn);
  GaussianCloud cloud;
  cloud.resize(count, 0);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k * sample.size() / count;
    cloud.positions[k] = sample.positions[i];
    cloud.log_scales[k] = sample.log_scales[i];
    cloud.rotations[k] = sample.rotations[i];
    cloud.opacity_logits[k] = sample.opacity_logits[i];
    const glm::vec3 color = glm::clamp(0.5f + static_cast<float>(kSh0) * sample.sh[i], 0.0f, 1.0f);
    const glm::dvec2 place = glm::abs(ground.place_of(glm::dvec3(sample.positions[i])));
    const glm::vec3 channels(glm::dot(color, glm::vec3(0.3f, 0.59f, 0.11f)), subject.holds[i],
                             third == ThirdChannel::hue
                                 ? 0.5f + 0.5f * (color.r - color.b)
                                 : static_cast<float>(std::min(std::max(place.x, place.y), 1.0)));
    cloud.sh[k] = (channels - 0.5f) / static_cast<float>(kSh0);
  }
  return cloud;
}

double mean(const Image& image, Channel channel) {
  double sum = 0;
  for (std::size_t i = channel; i < image.values.size(); i += 3)
    sum += static_cast<double>(image.values[i]);
  return 3 * sum / static_cast<double>(image.values.size());
}

// The mean difference of neighbouring pixels inside the subject. The outline of the subject is not
// a detail.
double mean_step(const Image& image, Channel channel) {
  double sum = 0;
  for (int y = 1; y < image.height; ++y) {
    for (int x = 1; x < image.width; ++x) {
      for (const glm::ivec2 other : {glm::ivec2(x - 1, y), glm::ivec2(x, y - 1)}) {
        if (std::min(image.at(x, y, kSubject), image.at(other.x, other.y, kSubject)) > 0.5f)
          sum += static_cast<double>(
              std::abs(image.at(x, y, channel) - image.at(other.x, other.y, channel)));
      }
    }
  }
  return 0.5 * sum / (image.width * image.height);
}

double mean_along_edge(const Image& image, Channel channel) {
  double sum = 0;
  for (int x = 0; x < image.width; ++x)
    sum += static_cast<double>(image.at(x, 0, channel) + image.at(x, image.height - 1, channel));
  for (int y = 0; y < image.height; ++y)
    sum += static_cast<double>(image.at(0, y, channel) + image.at(image.width - 1, y, channel));
  return sum / (2.0 * (image.width + image.height));
}

double share_inside(const Shape& shape, const Camera& camera) {
  double inside = 0, all = 0;
  for (std::size_t i = 0; i < shape.points.size(); ++i) {
    const glm::dvec3 at = camera.view_from_world * glm::dvec4(shape.points[i], 1);
    const auto weight = static_cast<double>(shape.weights[i]);
    all += weight;
    if (std::abs(at.x) * camera.focal_px.x < 0.5 * camera.width * at.z &&
        std::abs(at.y) * camera.focal_px.y < 0.5 * camera.height * at.z)
      inside += weight;
  }
  return all > 0 ? inside / all : 0;
}

double mean_difference(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.values.size(); i += 3) {
    float largest = 0;
    for (std::size_t channel = i; channel < i + 3; ++channel)
      largest = std::max(largest, std::abs(a.values[channel] - b.values[channel]));
    sum += static_cast<double>(largest);
  }
  return 3 * sum / static_cast<double>(a.values.size());
}

}  // namespace

Shape shape_of(const Subject& subject, double smallest) {
  Shape shape;
  shape.center = glm::dvec3(subject.box.center());
  glm::dvec3 half = 0.5 * glm::dvec3(subject.box.size());
  const bool tiny = !(std::max({half.x, half.y, half.z}) > smallest);
  if (tiny) half = glm::dvec3(smallest);
  shape.radius = glm::length(half);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 side(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    shape.corners.push_back(shape.center + side * half);
  }
  if (tiny) {
    shape.points = shape.corners;
    shape.weights.assign(shape.points.size(), 1.0f);
    return shape;
  }
  const std::size_t count = std::min(subject.positions.size(), kMostPoints);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k * subject.positions.size() / count;
    shape.points.emplace_back(subject.positions[i]);
    shape.weights.push_back(subject.weights[i]);
  }
  return shape;
}

Framing fit_view(const Shape& shape, glm::dvec3 toward_eye, glm::dvec3 up) {
  constexpr int kRounds = 8;  // the height is nearly proportional to 1 / distance
  const glm::dvec3 right = glm::normalize(glm::cross(-toward_eye, up));
  const glm::dvec3 down = glm::cross(-toward_eye, right);
  glm::dvec3 target = shape.center;
  double distance = 3 * shape.radius;
  ScreenExtents extents;
  for (int round = 0; round <= kRounds; ++round) {
    extents = extents_of(
        shape, {right, down, -toward_eye, target + distance * toward_eye, 0.05 * shape.radius});
    if (round == kRounds) break;
    // Move the target to the middle of the shape on the screen.
    const glm::dvec2 box = extents.box.center();
    const glm::dvec2 center = box + glm::clamp(extents.nearly.center() - box, glm::dvec2(-kMostOff),
                                               glm::dvec2(kMostOff));
    const double height = 2 * distance * std::tan(0.5 * kVerticalFov);
    target += height * (center.x * right + center.y * down);
    // Change the distance so that the shape fills the wanted part of the screen.
    const double smallest =
        std::max(kLeastFilled / extents.box.height(),
                 std::min(kLeastDense / extents.dense.height(), kFilled / extents.box.height()));
    const double factor = std::max(
        smallest, std::min(kFilled / extents.box.height(), kShown / extents.nearly.height()));
    distance = std::max(distance / std::clamp(factor, 0.5, 2.0), 0.7 * shape.radius);
  }
  Framing framing;
  framing.eye = target + distance * toward_eye;
  framing.target = target;
  framing.up = up;
  framing.vertical_fov = kVerticalFov;
  framing.aspect = 2 * std::max(-extents.box.low.x, extents.box.high.x) / kShown;
  framing.farthest =
      framing.aspect > kLine ? framing.aspect : std::max(1.0, extents.box.height() / kLeastFilled);
  framing.near_depth = std::min(0.2, 0.01 * distance);
  return framing;
}

CandidateViews::CandidateViews(const CloudSample& sample, const Subject& subject,
                               const Ground& ground, ThreadPool& pool, ThirdChannel third)
    : sample_(sample),
      ground_(ground),
      shape_(shape_of(subject, static_cast<double>(smallest_framing(sample.gaussians)))),
      sizes_(sample.gaussians.size()),
      renderer_(make_renderer(Backend::cpu, pool)) {
  const auto& log_scales = sample.gaussians.log_scales;
  std::transform(log_scales.begin(), log_scales.end(), sizes_.begin(),
                 [](const glm::vec3& s) { return std::exp(static_cast<double>(largest_of(s))); });
  GaussianCloud cloud = coded(sample.gaussians, subject, ground, third);
  // Fewer Gaussians are drawn larger, so that they cover the same area.
  const double thinned = sample.represented * static_cast<double>(sample.gaussians.size()) /
                         static_cast<double>(std::max<std::size_t>(cloud.size(), 1));
  settings_.splat_scale = static_cast<float>(std::clamp(std::sqrt(thinned), 1.0, 16.0));
  renderer_->upload(std::move(cloud), {});
}

ViewQuality CandidateViews::measure(const Framing& framing, double free) {
  Camera camera = framed_camera(framing, kWidth, kHeight);
  const Image image = renderer_->render(camera, settings_).color;
  ViewQuality quality;
  quality.coverage = mean(image, kSubject);
  quality.detail = mean_step(image, kBrightness);
  quality.third_detail = mean_step(image, kThird);
  quality.cut = mean_along_edge(image, kSubject);
  quality.shown = share_inside(shape_, camera);
  quality.blocked = is_inside_a_gaussian(framing.eye);
  camera.near_depth = std::max(camera.near_depth, free);
  quality.obstruction = mean_difference(image, renderer_->render(camera, settings_).color);
  return quality;
}

double CandidateViews::border_share(const Camera& camera) {
  return mean(renderer_->render(camera, settings_).color, kThird);
}

bool CandidateViews::is_inside_a_gaussian(glm::dvec3 point) const {
  constexpr double kReach = 3;
  const GaussianCloud& gaussians = sample_.gaussians;
  for (std::size_t i = 0; i < gaussians.size(); ++i) {
    const glm::dvec3 from = point - glm::dvec3(gaussians.positions[i]);
    const double reach = kReach * sizes_[i];
    if (!(glm::dot(from, from) < reach * reach) || sample_.opacities[i] < kVisible) continue;
    const glm::dmat3 turn = glm::mat3_cast(glm::normalize(glm::dquat(gaussians.rotations[i])));
    const glm::dvec3 sizes = glm::exp(glm::dvec3(gaussians.log_scales[i]));
    const glm::dvec3 deviations = from * turn / glm::max(sizes, 1e-15);
    if (glm::dot(deviations, deviations) < kReach * kReach) return true;
  }
  return false;
}

}  // namespace qs
