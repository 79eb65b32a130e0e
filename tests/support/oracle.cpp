// SPDX-License-Identifier: MIT
#include "support/oracle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace qs::test {
namespace {

struct OracleSplat {
  std::size_t index;
  std::uint32_t depth_bits;
  glm::dvec2 mean;
  glm::dmat2 inverse;
  double opacity;
  glm::dvec3 color;
};

/// Associated Legendre function P_l^m(x) with the Condon-Shortley phase, by recurrence.
double legendre(int l, int m, double x) {
  double pmm = 1;
  for (int i = 1; i <= m; ++i) pmm *= -(2 * i - 1) * std::sqrt(1 - x * x);
  if (l == m) return pmm;
  double previous = pmm, current = x * (2 * m + 1) * pmm;
  for (int n = m + 2; n <= l; ++n) {
    const double next = ((2 * n - 1) * x * current - (n + m - 1) * previous) / (n - m);
    previous = current;
    current = next;
  }
  return current;
}

bool make_splat(const GaussianCloud& cloud, const Camera& camera, const OracleSettings& settings,
                std::size_t i, OracleSplat& splat) {
  const glm::dmat3 world_to_view(camera.view_from_world);
  const glm::dvec3 p = world_to_view * glm::dvec3(cloud.positions[i]) + camera.view_from_world[3];
  if (!(p.z > camera.near_depth)) return false;

  const glm::dmat3 sigma = settings.splat_scale * settings.splat_scale * world_to_view *
                           covariance(cloud, i) * glm::transpose(world_to_view);  // in view axes

  const double limit_x = 1.3 * camera.width / (2 * camera.focal_px.x);
  const double limit_y = 1.3 * camera.height / (2 * camera.focal_px.y);
  const double x = std::clamp(p.x / p.z, -limit_x, limit_x) * p.z;
  const double y = std::clamp(p.y / p.z, -limit_y, limit_y) * p.z;
  const glm::dvec3 du(camera.focal_px.x / p.z, 0, -camera.focal_px.x * x / (p.z * p.z));
  const glm::dvec3 dv(0, camera.focal_px.y / p.z, -camera.focal_px.y * y / (p.z * p.z));
  const double xy = glm::dot(du, sigma * dv);
  glm::dmat2 on_screen(glm::dot(du, sigma * du), xy, xy, glm::dot(dv, sigma * dv));
  const double before = glm::determinant(on_screen);
  on_screen[0][0] += settings.dilation;
  on_screen[1][1] += settings.dilation;
  const double after = glm::determinant(on_screen);
  if (!(after > 0)) return false;

  splat.index = i;
  splat.depth_bits = std::bit_cast<std::uint32_t>(static_cast<float>(p.z));
  splat.mean = {camera.focal_px.x * p.x / p.z + camera.center_px.x,
                camera.focal_px.y * p.y / p.z + camera.center_px.y};
  splat.inverse = glm::inverse(on_screen);
  splat.opacity = 1 / (1 + std::exp(-static_cast<double>(cloud.opacity_logits[i])));
  if (settings.antialiased) splat.opacity *= std::sqrt(std::max(2.5e-5, before / after));

  const glm::dvec3 direction = glm::normalize(glm::dvec3(cloud.positions[i]) - camera.position());
  const int degree = std::min(settings.sh_degree, cloud.sh_degree);
  splat.color = glm::max(0.5 + sh_sum(cloud, i, degree, direction), glm::dvec3(0));
  return true;
}

}  // namespace

glm::dmat3 covariance(const glm::dquat& q, const glm::dvec3& scale) {
  const glm::dmat3 rotation(  // columns, from the definition of a quaternion's rotation
      1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.w * q.z), 2 * (q.x * q.z - q.w * q.y),
      2 * (q.x * q.y - q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z + q.w * q.x),
      2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y));
  const glm::dmat3 half(rotation[0] * scale.x, rotation[1] * scale.y, rotation[2] * scale.z);
  return half * glm::transpose(half);
}

glm::dmat3 covariance(const GaussianCloud& cloud, std::size_t i) {
  return covariance(glm::dquat(cloud.rotations[i]), glm::exp(glm::dvec3(cloud.log_scales[i])));
}

glm::dvec3 sh_sum(const GaussianCloud& cloud, std::size_t i, int degree, glm::dvec3 direction) {
  const auto stride = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  glm::dvec3 sum(0);
  for (int l = 0; l <= degree; ++l) {
    for (int order = -l; order <= l; ++order) {
      const auto k = static_cast<std::size_t>(l * l + l + order);
      sum += spherical_harmonic(l, order, direction) * glm::dvec3(cloud.sh[i * stride + k]);
    }
  }
  return sum;
}

double spherical_harmonic(int l, int m, glm::dvec3 d) {
  const int order = std::abs(m);
  double factorials = 1;  // (l - |m|)! / (l + |m|)!
  for (int i = l - order + 1; i <= l + order; ++i) factorials /= i;
  const double norm = std::sqrt((2 * l + 1) / (4 * M_PI) * factorials);
  const double phi = std::atan2(d.y, d.x), p = legendre(l, order, d.z);
  if (m == 0) return norm * p;
  return std::sqrt(2.0) * norm * p * (m > 0 ? std::cos(order * phi) : std::sin(order * phi));
}

Image oracle_image(const GaussianCloud& cloud, const Camera& camera,
                   const OracleSettings& settings) {
  std::vector<OracleSplat> splats;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    OracleSplat splat;
    if (make_splat(cloud, camera, settings, i, splat)) splats.push_back(splat);
  }
  std::stable_sort(splats.begin(), splats.end(), [](const OracleSplat& a, const OracleSplat& b) {
    return a.depth_bits < b.depth_bits;
  });
  Image image(camera.width, camera.height, 3);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      double transmittance = 1;
      glm::dvec3 color(0);
      for (const OracleSplat& splat : splats) {
        const glm::dvec2 d = glm::dvec2(x, y) - splat.mean;
        const double power = -0.5 * glm::dot(d, splat.inverse * d);
        if (power > 0) continue;
        const double alpha = std::min(0.99, splat.opacity * std::exp(power));
        if (alpha < 1.0 / 255) continue;
        if (settings.acts && !settings.acts(splat.index, x, y)) continue;
        if (transmittance * (1 - alpha) < 1e-4) break;
        color += alpha * transmittance * splat.color;
        transmittance *= 1 - alpha;
      }
      color += transmittance * settings.background;
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(color[c]);
    }
  }
  return image;
}

}  // namespace qs::test
