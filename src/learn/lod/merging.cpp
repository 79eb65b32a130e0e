// SPDX-License-Identifier: MIT
#include "learn/lod/merging.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace qs {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
// A covariance in the plane of two axes.
struct Flat {
  float xx, xy, yy;
  float determinant() const { return std::max(xx * yy - xy * xy, 1e-36f); }
};

// Seen along axis 0, 1 or 2.
Flat seen_along(int axis, const LodCovariance& c) {
  return axis == 0   ? Flat{c[3], c[4], c[5]}
         : axis == 1 ? Flat{c[0], c[2], c[5]}
                     : Flat{c[0], c[1], c[3]};
}

// Integral of the product of two Gaussians of peak 1 at the distance (dx, dy). `roots`: product of
// the roots of their determinants.
float overlap(const Flat& a, const Flat& b, float roots, float dx, float dy) {
  const Flat sum{a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
  const float determinant = sum.determinant();
  const float q = (sum.yy * dx * dx - 2 * sum.xy * dx * dy + sum.xx * dy * dy) / determinant;
  return 2 * kPi * roots / std::sqrt(determinant) * std::exp(-0.5f * q);
}

float product(const LodGaussian& a, const LodGaussian& b) {
  float sum = kLodBackground;
  for (std::size_t i = 0; i < kLodColors; ++i) sum += a.color[i] * b.color[i];
  return sum;
}

LodCovariance widened(LodCovariance c, float v) {
  for (const std::size_t i : {0, 3, 5}) c[i] += v;
  return c;
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

void set_opacity(LodGaussian& leaf, float opacity) {
  leaf.opacities = opacity;
  leaf.mass = opacity * ellipsoid_area(leaf.covariance);
}

float share_of(const LodGaussian& a, const LodGaussian& b) {
  return (a.mass + kLeastLodMass) / (a.mass + b.mass + 2 * kLeastLodMass);
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
  if (g.is_leaf) return {g.opacities, g.covariance};
  const LodCovariance wide = widened(g.covariance, v);
  const float area = ellipsoid_area(wide);
  const float m = area > 0 ? (g.mass + 4 * kPi * v * g.opacities) / area : 0;
  if (m <= 1) return {m, g.covariance};
  // The widened Gaussian grows; the renderer widens it again.
  DrawnLod grown{1, g.covariance};
  const float growth = harmonic_number(m);
  for (float& value : grown.covariance) value *= growth;
  grown.covariance = widened(grown.covariance, (growth - 1) * v);
  return grown;
}

float merging_error(const LodGaussian& a, const LodGaussian& b, const LodGaussian& node, float v,
                    bool antialiased) {
  // The node's colour is p a + q b, so its products follow from theirs.
  const float aa = product(a, a), bb = product(b, b), ab = product(a, b);
  const float p = share_of(a, b), q = 1 - p;
  const float an = p * aa + q * ab, bn = p * ab + q * bb, nn = p * an + q * bn;
  const glm::vec3 to_b = b.mean - a.mean, a_to_node = node.mean - a.mean,
                  b_to_node = node.mean - b.mean;
  const float fitted = antialiased ? 0 : v;
  const std::array<DrawnLod, 3> shown{drawn(a, fitted), drawn(b, fitted), drawn(node, fitted)};
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int x = axis == 0 ? 1 : 0, y = axis == 2 ? 1 : 2;
    std::array<Flat, 3> flat;
    std::array<float, 3> root, light;
    for (std::size_t k = 0; k < 3; ++k) {
      const Flat sharp = seen_along(axis, shown[k].covariance);
      flat[k] = {sharp.xx + v, sharp.xy, sharp.yy + v};
      root[k] = std::sqrt(flat[k].determinant());
      light[k] = shown[k].opacity;
      if (antialiased) light[k] *= std::sqrt(sharp.determinant()) / root[k];
    }
    const auto both = [&](std::size_t i, std::size_t k, const glm::vec3& d) {
      return 2 * light[i] * light[k] * overlap(flat[i], flat[k], root[i] * root[k], d[x], d[y]);
    };
    sum += kPi * (light[0] * light[0] * aa * root[0] + light[1] * light[1] * bb * root[1] +
                  light[2] * light[2] * nn * root[2]) +
           ab * both(0, 1, to_b) - an * both(0, 2, a_to_node) - bn * both(1, 2, b_to_node);
  }
  // Gaussians far apart or huge can exceed the range of floats.
  constexpr float kMost = std::numeric_limits<float>::max() / 1024;
  return sum / 3 < kMost ? std::max(sum / 3, 0.0f) : kMost;
}

}  // namespace qs
