// SPDX-License-Identifier: MIT
#include "learn/lod/merging.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace qs {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
LodCovariance widened(LodCovariance c, float v) {
  for (const std::size_t i : {0, 3, 5}) c[i] += v;
  return c;
}

// Behind the filter the node has the integral of its layers. `integral`: of m layers at one place,
// in integrals of one opaque layer.
template <class Integral>
DrawnLod covering(const LodGaussian& g, float v, const Integral& integral) {
  if (g.is_leaf) return {g.opacities, g.covariance};
  const float area = ellipsoid_area(widened(g.covariance, v));
  const float layers = area > 0 ? (g.mass + 4 * kPi * v * g.opacities) / area : 0;
  const float growth = integral(layers);
  if (growth <= 1) return {growth, g.covariance};
  // The widened Gaussian grows; the renderer widens it again.
  DrawnLod grown{1, g.covariance};
  for (float& value : grown.covariance) value *= growth;
  grown.covariance = widened(grown.covariance, (growth - 1) * v);
  return grown;
}

}  // namespace

float ellipsoid_area(const LodCovariance& c) {
  // The eigenvalues of the cofactors are the squares of bc, ca and ab, the products of the axes.
  // The area is 4 pi times their mean of power 1.6 (Thomsen). The mean of power 2 is the trace's;
  // the second invariant, 1 for a ball and 0 for a disc, corrects it.
  const float trace = c[0] + c[3] + c[5];
  if (!(trace > 0)) return 0;
  const float s = 1 / trace;
  const float xx = c[0] * s, xy = c[1] * s, xz = c[2] * s, yy = c[3] * s, yz = c[4] * s,
              zz = c[5] * s;
  const float kx = yy * zz - yz * yz, ky = xx * zz - xz * xz, kz = xx * yy - xy * xy;
  const float first = std::max(kx + ky + kz, 1e-12f);
  const float second = xx * kx - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  const float evenness = std::clamp(3 * second / (first * first), 0.0f, 1.0f);
  return 4 * kPi * trace * std::sqrt(first / 3) * (0.866f + 0.134f * evenness);
}

float harmonic_number(float m) {
  const float x = m + 0.5f;
  return std::log(x) + std::numbers::egamma_v<float> + 1 / (24 * x * x);
}

float exponential_integral(float m) {
  // Abramowitz, Stegun 1964, 5.1.53 and 5.1.54.
  if (m < 1)
    return m * (0.99999193f -
                m * (0.24991055f - m * (0.05519968f - m * (0.00976004f - m * 0.00107857f))));
  if (m > 50) return std::log(m) + std::numbers::egamma_v<float>;
  const float rest = (m * m + 2.334733f * m + 0.250621f) / (m * m + 3.330657f * m + 1.681534f);
  return std::log(m) + std::numbers::egamma_v<float> + std::exp(-m) / m * rest;
}

void set_opacity(LodGaussian& leaf, float opacity) {
  leaf.opacities = opacity;
  leaf.mass = opacity * ellipsoid_area(leaf.covariance);
}

LodGaussian merged(const LodGaussian& a, const LodGaussian& b) {
  LodGaussian node;
  const float p = share_of(a, b), q = 1 - p;
  const glm::vec3 d = a.mean - b.mean;
  node.mean = b.mean + p * d;
  const LodCovariance square{d.x * d.x, d.x * d.y, d.x * d.z, d.y * d.y, d.y * d.z, d.z * d.z};
  for (std::size_t i = 0; i < square.size(); ++i)
    node.covariance[i] = p * a.covariance[i] + q * b.covariance[i] + p * q * square[i];
  for (std::size_t i = 0; i < kLodColors; ++i) node.color[i] = p * a.color[i] + q * b.color[i];
  node.mass = a.mass + b.mass;
  node.opacities = a.opacities + b.opacities;
  node.is_leaf = false;
  return node;
}

DrawnLod drawn(const LodGaussian& g, float v) {
  return covering(g, v, [](float m) { return m <= 1 ? m : harmonic_number(m); });
}

DrawnLod drawn_faint(const LodGaussian& g, float v) { return covering(g, v, exponential_integral); }

}  // namespace qs
