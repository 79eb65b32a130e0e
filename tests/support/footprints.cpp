// SPDX-License-Identifier: MIT
#include "support/footprints.h"

#include <cmath>

#include "raster/kernel/blend.h"

namespace qs::test {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

double log_uniform(std::mt19937& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}

glm::vec2 inside(std::mt19937& random, int width, int height) {
  return {static_cast<float>(uniform(random, -8, width + 8)),
          static_cast<float>(uniform(random, -8, height + 8))};
}

double any_angle(std::mt19937& random) {
  // Axis-aligned ellipses (b = 0) and ellipses close to them are important, because the quadrants
  // change sides there.
  switch (random() % 4) {
    case 0:
      return 0.5 * M_PI * static_cast<double>(random() % 4);
    case 1:
      return 0.5 * M_PI * static_cast<double>(random() % 4) + uniform(random, -1e-4, 1e-4);
    default:
      return uniform(random, 0, 2 * M_PI);
  }
}

double any_opacity(std::mt19937& random) {
  return random() % 4 == 0 ? 1.0 : log_uniform(random, 1.01 / 255, 1);
}

}  // namespace

Footprint make_footprint(glm::vec2 mean_px, double major, double minor, double angle,
                         double opacity) {
  const double c = std::cos(angle), s = std::sin(angle), u = major * major, v = minor * minor;
  Footprint footprint;
  footprint.mean_px = mean_px;
  footprint.covariance = {static_cast<float>(c * c * u + s * s * v + kDilation),
                          static_cast<float>(c * s * (u - v)),
                          static_cast<float>(s * s * u + c * c * v + kDilation)};
  footprint.determinant = footprint.covariance.determinant();
  const auto& cov = footprint.covariance;
  footprint.conic = {cov.yy / footprint.determinant, -cov.xy / footprint.determinant,
                     cov.xx / footprint.determinant};
  footprint.gamma = 2.0f * static_cast<float>(kLn2) * static_cast<float>(std::log2(255 * opacity));
  return footprint;
}

const std::vector<FootprintKind>& footprint_kinds() {
  static const std::vector<FootprintKind> kinds = {
      {"round",
       [](std::mt19937& r, int w, int h) {
         const double size = log_uniform(r, 0.5, 60);
         return make_footprint(inside(r, w, h), size, size * uniform(r, 0.5, 1), any_angle(r),
                               any_opacity(r));
       }},
      {"needle",
       [](std::mt19937& r, int w, int h) {
         const double length =
             log_uniform(r, 30, 1640);  // the dilation keeps the other axis at 0.55
         return make_footprint(inside(r, w, h), length, 0, any_angle(r), any_opacity(r));
       }},
      {"huge",
       [](std::mt19937& r, int w, int h) {
         const double size = log_uniform(r, 300, 30000);
         return make_footprint(inside(r, w, h), size, size * uniform(r, 0.05, 1), any_angle(r),
                               any_opacity(r));
       }},
      {"tiny",
       [](std::mt19937& r, int w, int h) {
         return make_footprint(inside(r, w, h), log_uniform(r, 1e-4, 0.3), 0, any_angle(r),
                               any_opacity(r));
       }},
      {"off-screen",
       [](std::mt19937& r, int w, int h) {
         const double size = log_uniform(r, 1, 200);
         const double angle = uniform(r, 0, 2 * M_PI),
                      distance = std::max(w, h) * uniform(r, 0.7, 20);
         const glm::vec2 mean(static_cast<float>(w / 2 + distance * std::cos(angle)),
                              static_cast<float>(h / 2 + distance * std::sin(angle)));
         return make_footprint(mean, size, size * uniform(r, 0.1, 1), any_angle(r), any_opacity(r));
       }},
      {"border",
       [](std::mt19937& r, int w, int h) {
         const glm::vec2 mean(
             static_cast<float>(16 * static_cast<int>(uniform(r, -1, w / 16.0 + 2))),
             static_cast<float>(16 * static_cast<int>(uniform(r, -1, h / 16.0 + 2))));
         const double size = log_uniform(r, 0.5, 40);
         return make_footprint(mean, size, size * uniform(r, 0.02, 1), any_angle(r),
                               any_opacity(r));
       }},
      {"faint",
       [](std::mt19937& r, int w, int h) {
         const double size = log_uniform(r, 5, 200);
         return make_footprint(inside(r, w, h), size, size * uniform(r, 0.02, 1), any_angle(r),
                               uniform(r, 1.0001 / 255, 1.5 / 255));
       }},
  };
  return kinds;
}

float opacity_of(const Footprint& footprint) {
  return static_cast<float>(std::exp(0.5 * static_cast<double>(footprint.gamma)) / 255);
}

float alpha_at(const Footprint& footprint, float opacity, int x, int y) {
  const Splat splat = make_splat(footprint, opacity, glm::vec3(1));
  const float power = log2_falloff(splat, static_cast<float>(x) - footprint.mean_px.x,
                                   static_cast<float>(y) - footprint.mean_px.y);
  return power <= 0 ? alpha_of(splat, power) : 0;
}

}  // namespace qs::test
