// SPDX-License-Identifier: MIT
#include "app/framing/candidate_views.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/quaternion.hpp>

#include "app/framing/framing.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

constexpr int kWidth = 64, kHeight = 36;
constexpr std::size_t kMostDrawn = 12'000;
constexpr float kVisible = 0.1f;  ///< opacity
enum Channel { kBrightness, kSubject, kBorder };

// Every n-th Gaussian of the sample, with the colour channels as named above.
GaussianCloud coded(const GaussianCloud& sample, const Subject& subject, const Ground& ground) {
  const std::size_t count = std::min(sample.size(), kMostDrawn);
  GaussianCloud cloud;
  cloud.resize(count, 0);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k * sample.size() / count;
    cloud.positions[k] = sample.positions[i];
    cloud.log_scales[k] = sample.log_scales[i];
    cloud.rotations[k] = sample.rotations[i];
    cloud.opacity_logits[k] = sample.opacity_logits[i];
    const glm::vec3 color = 0.5f + static_cast<float>(kSh0) * sample.sh[i];
    const glm::dvec2 place = glm::abs(ground.place_of(glm::dvec3(sample.positions[i])));
    const glm::vec3 channels(glm::dot(glm::clamp(color, 0.0f, 1.0f), glm::vec3(0.3f, 0.59f, 0.11f)),
                             subject.holds[i],
                             static_cast<float>(std::min(std::max(place.x, place.y), 1.0)));
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
double mean_step(const Image& image) {
  double sum = 0;
  for (int y = 1; y < image.height; ++y) {
    for (int x = 1; x < image.width; ++x) {
      for (const glm::ivec2 other : {glm::ivec2(x - 1, y), glm::ivec2(x, y - 1)}) {
        if (std::min(image.at(x, y, kSubject), image.at(other.x, other.y, kSubject)) > 0.5f)
          sum += static_cast<double>(
              std::abs(image.at(x, y, kBrightness) - image.at(other.x, other.y, kBrightness)));
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

CandidateViews::CandidateViews(const CloudSample& sample, const Subject& subject,
                               const Ground& ground, ThreadPool& pool)
    : sample_(sample),
      ground_(ground),
      shape_(shape_of(subject, static_cast<double>(smallest_framing(sample.gaussians)))),
      sizes_(sample.gaussians.size()),
      renderer_(make_renderer(Backend::cpu, pool)) {
  const auto& log_scales = sample.gaussians.log_scales;
  std::transform(log_scales.begin(), log_scales.end(), sizes_.begin(),
                 [](const glm::vec3& s) { return std::exp(static_cast<double>(largest_of(s))); });
  GaussianCloud cloud = coded(sample.gaussians, subject, ground);
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
  quality.detail = mean_step(image);
  quality.cut = mean_along_edge(image, kSubject);
  quality.shown = share_inside(shape_, camera);
  quality.blocked = is_inside_a_gaussian(framing.eye);
  camera.near_depth = std::max(camera.near_depth, free);
  quality.obstruction = mean_difference(image, renderer_->render(camera, settings_).color);
  return quality;
}

double CandidateViews::border_share(const Camera& camera) {
  return mean(renderer_->render(camera, settings_).color, kBorder);
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
