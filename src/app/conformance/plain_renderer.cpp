// SPDX-License-Identifier: MIT
#include "app/conformance/plain_renderer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "raster/kernel/project.h"
#include "raster/kernel/sh.h"
#include "raster/scene/activated_cloud.h"

namespace qs {
namespace {

struct PlainSplat {
  glm::dvec2 mean;
  glm::dvec3 conic;  // (a, b, c) of a dx^2 + 2 b dx dy + c dy^2
  double opacity;
  glm::dvec3 color;
  double reach2;  // squared distance in standard deviations beyond which it is not drawn
  float key;      // Gaussians are sorted by it
  std::size_t gaussian;
};

class Plain {
 public:
  Plain(const GaussianCloud& cloud, const Camera& camera, const RenderSettings& settings,
        const Rules& rules)
      : cloud_(cloud), settings_(settings), rules_(rules), view_(make_view<double>(camera)) {
    for (int axis = 0; axis < 2; ++axis) view_.slope_limit[axis] *= rules.slope_limit;
    for (std::size_t i = 0; i < cloud.size(); ++i) project(i);
    std::ranges::sort(splats_, [&](const PlainSplat& a, const PlainSplat& b) {
      if (a.key != b.key) return a.key < b.key;
      return rules.reversed_ties ? a.gaussian > b.gaussian : a.gaussian < b.gaussian;
    });
  }

  glm::dvec3 pixel(double x, double y) const {
    glm::dvec3 color(0);
    double transmittance = 1;
    for (const PlainSplat& splat : splats_) {
      const double alpha = alpha_at(splat, x, y);
      if (alpha < rules_.alpha_min) continue;
      const double next = transmittance * (1 - alpha);
      const bool stops = rules_.stop != Rules::Stop::never && next < rules_.transmittance_min;
      if (stops && rules_.stop == Rules::Stop::before) break;
      color += alpha * transmittance * splat.color;
      transmittance = next;
      if (stops) break;
    }
    return color + transmittance * glm::dvec3(settings_.background);
  }

 private:
  // The alpha at a pixel; 0 if the Gaussian is not drawn there.
  double alpha_at(const PlainSplat& splat, double x, double y) const {
    const double dx = x - splat.mean.x, dy = y - splat.mean.y;
    const double distance2 =
        splat.conic.x * dx * dx + splat.conic.z * dy * dy + 2 * splat.conic.y * dx * dy;
    if (distance2 < 0 || distance2 > splat.reach2) return 0;
    return std::min(rules_.alpha_max, splat.opacity * std::exp(-rules_.falloff * distance2));
  }

  void project(std::size_t i) {
    const glm::dvec3 position(cloud_.positions[i]), point = to_view(view_, position);
    if (!(point.z > view_.near_depth)) return;
    Covariance2<double> covariance = project_covariance(view_, point, world_covariance(cloud_, i));
    const double before = covariance.determinant();
    covariance.xx += settings_.dilation;
    covariance.yy += settings_.dilation;
    const double determinant = covariance.determinant();
    if (!(determinant > 0) || !std::isfinite(determinant)) return;
    PlainSplat splat;
    splat.opacity = opacity_of_logit(cloud_.opacity_logits[i]);
    if (settings_.antialiased.value_or(cloud_.antialiased))
      splat.opacity *= compensation(before, determinant);
    splat.reach2 = reach2(splat.opacity);
    splat.mean = to_pixel(view_, point);
    if (rules_.eigenvalue_floor > 0 && !lengthen(covariance)) return;
    splat.conic =
        glm::dvec3(covariance.yy, -covariance.xy, covariance.xx) / covariance.determinant();
    splat.color = color_of(i, position);
    splat.key = key_of(point);
    splat.gaussian = i;
    splats_.push_back(splat);
  }

  // The eigenvalues get the floor's distance from their mean. False if an eigenvalue is not
  // positive.
  bool lengthen(Covariance2<double>& covariance) const {
    const double mean = 0.5 * (covariance.xx + covariance.yy);
    const double root =
        std::sqrt(std::max(rules_.eigenvalue_floor, mean * mean - covariance.determinant()));
    if (!(mean - root > 0)) return false;
    glm::dvec2 axis(covariance.xy, mean + root - covariance.xx);
    // For an ellipse along x both components are 0. In the viewers with this mistake, rounding then
    // gives the y axis.
    axis = glm::length(axis) < kAlongX * covariance.xx ? glm::dvec2(0, 1) : glm::normalize(axis);
    const double xx = axis.x * axis.x, yy = axis.y * axis.y, xy = axis.x * axis.y;
    covariance = {(mean + root) * xx + (mean - root) * yy, 2 * root * xy,
                  (mean + root) * yy + (mean - root) * xx};
    return true;
  }

  double reach2(double opacity) const {
    constexpr double kSlack = 1e-6;  // alpha_min decides, not this bound
    const double visible = std::log(opacity / std::max(rules_.alpha_min, kNegligible));
    return std::min(rules_.cut_sigmas * rules_.cut_sigmas, visible / rules_.falloff + kSlack);
  }

  float key_of(const glm::dvec3& point) const {
    if (rules_.order == Rules::Order::file) return 0;
    if (rules_.order == Rules::Order::distance) return static_cast<float>(glm::length(point));
    const auto depth = static_cast<float>(point.z);
    return rules_.order == Rules::Order::depth ? depth : -depth;
  }

  glm::dvec3 color_of(std::size_t i, const glm::dvec3& position) const {
    const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud_.sh_degree));
    glm::dvec3 direction = glm::normalize(position - view_.position);
    if (rules_.view_directions) direction = glm::dmat3(view_.view_from_world) * direction;
    // sh_color() clamps at 0: the offset of the first coefficient keeps darker colours.
    const double offset = rules_.clamps_dark ? 0 : kDarkest;
    const glm::vec3* sh = cloud_.sh.data() + i * coefficients;
    glm::dvec3 color =
        sh_color<double>(std::min(settings_.sh_degree, cloud_.sh_degree), direction,
                         [&](int k) { return glm::dvec3(sh[k]) + (k == 0 ? offset / kSh0 : 0); });
    color -= offset;
    return rules_.clamps_bright ? glm::min(color, glm::dvec3(1)) : color;
  }

  static constexpr double kNegligible = 1e-9;  // alpha without an effect on any scene
  static constexpr double kAlongX = 1e-5;
  static constexpr double kDarkest = 1024;  // no colour of a scene is below -kDarkest

  const GaussianCloud& cloud_;
  const RenderSettings& settings_;
  const Rules& rules_;
  View<double> view_;
  std::vector<PlainSplat> splats_;  // front to back
};

}  // namespace

Image draw_plain(const GaussianCloud& cloud, const Camera& camera, const RenderSettings& settings,
                 const Rules& rules) {
  const Plain plain(cloud, camera, settings, rules);
  Image image(camera.width, camera.height, 3);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const glm::dvec3 color = plain.pixel(x, y);
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(color[c]);
    }
  }
  return image;
}

}  // namespace qs
