// SPDX-License-Identifier: MIT
//
// The mathematics of levels of detail: one Gaussian in the place of a pair. pair_errors.h has the
// difference of their pictures.
//
// The *mass* of a Gaussian is its opacity times the area of its ellipsoid, which is four times the
// mean area of its projections. A merged Gaussian has the mean and the covariance of the mixture,
// weighted by mass. m = mass / area is its opacity; if m is above 1, it stands for m coincident
// opaque Gaussians: it becomes opaque, and its covariance grows by the harmonic number H_m, because
// the integral of 1 - (1 - exp(-r^2/2))^m over the plane is 2 pi H_m.
//
// Renderers widen every Gaussian by a low-pass filter of the variance v and keep its opacity, so
// many small Gaussians together cover more than their mass. With the sum of the leaves' opacities a
// node's mass at v is mass + 4 pi v * sum, and its area is the area of its widened ellipsoid.
#pragma once

#include <array>
#include <cstddef>

#include <glm/vec3.hpp>

namespace qs {

/// xx, xy, xz, yy, yz, zz; world units^2.
using LodCovariance = std::array<float, 6>;

/// RGB of the mean over all directions minus 0.5, then the coefficients of SH degree 1, times the
/// constant of degree 0: a product of two of these is the mean product over all directions.
inline constexpr std::size_t kLodColors = 12;

/// Keeps shares defined for Gaussians that show nothing.
inline constexpr float kLeastLodMass = 1e-30f;

struct LodGaussian {
  glm::vec3 mean{0};           ///< world units
  LodCovariance covariance{};  ///< of the mixture
  float mass = 0;              ///< sum of opacity times area over its leaves, world units^2
  float opacities = 0;         ///< sum of the leaves' opacities
  bool is_leaf = true;
  std::array<float, kLodColors> color{};
};

/// A Gaussian as it is drawn.
struct DrawnLod {
  float opacity = 0;  ///< 0..1
  LodCovariance covariance{};
};

/// Area of the ellipsoid of one standard deviation, within 2 % for every ratio of its axes.
float ellipsoid_area(const LodCovariance& covariance);

/// H_m = psi(m + 1) + Euler's constant within 0.2 %, for real m >= 1.
float harmonic_number(float m);

/// The integral of (1 - e^-t) / t from 0 to m within 0.01 %, for m >= 0.
float exponential_integral(float m);

/// Sets the mass and the opacities of a leaf that has its mean and covariance.
void set_opacity(LodGaussian& leaf, float opacity);

/// The share of `a` in merged(a, b), 0..1.
inline float share_of(const LodGaussian& a, const LodGaussian& b) {
  return (a.mass + kLeastLodMass) / (a.mass + b.mass + 2 * kLeastLodMass);
}

/// The node in the place of both.
LodGaussian merged(const LodGaussian& a, const LodGaussian& b);

/// The Gaussian as it is drawn by renderers whose filter has the variance `v`, world units^2.
/// Leaves are drawn as they are. v = 0: for viewers whose filter is unknown, and for filters that
/// keep the light of each Gaussian.
DrawnLod drawn(const LodGaussian& gaussian, float v);

/// The same for a node with many faint leaves, which hide each other: m of them at one place have
/// the opacity 1 - e^-m.
DrawnLod drawn_faint(const LodGaussian& gaussian, float v);

}  // namespace qs
