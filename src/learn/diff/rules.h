// SPDX-License-Identifier: MIT
//
// The rules in which differentiable rasterizers differ. The defaults are this project's, which its
// trainer uses.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/blend.h"
#include "raster/kernel/constants.h"
#include "raster/kernel/cull/mode.h"
#include "raster/kernel/cull/radius.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::diff {

/// Bounds of the slopes x/z and y/z inside the Jacobian of the projection.
struct SlopeBounds {
  glm::dvec2 low, high;
};

struct Rules {
  double near_depth = 0.2;  ///< Gaussians with view z at or below this are not drawn; >= 0
  /// Gaussians with view z above this are not drawn.
  double far_depth = std::numeric_limits<double>::infinity();
  double dilation = kDilation;  ///< px^2 added to both variances, >= 0
  double splat_scale = 1;       ///< factor on every standard deviation, > 0
  bool antialiased = false;     ///< scale opacities by compensation(), see kernel/project.h
  double compensation_floor = kCompensationFloor;  ///< lower bound of the ratio in it, >= 0
  /// Unset: kSlopeMargin times the half field of view of a centred camera, to both sides.
  std::optional<SlopeBounds> slopes;
  bool normalises_rotations = true;  ///< false: quaternions are used with the length that they have
  bool zero_color_passes = false;    ///< see clamp_gradient() of kernel/gradient/sh.h

  double alpha_max = fp64::kAlphaMax;  ///< alpha is clamped to this, < 1
  bool alpha_max_passes = true;        ///< a clamped alpha passes its gradient on
  /// A pixel also stops in front of a Gaussian that would push its transmittance to exactly 1e-4.
  bool stops_at_equal = false;

  RadiusRule radius_rule = RadiusRule::inria;  ///< radius rule of the radii that project() returns
  /// Gaussians whose radii are at most this many pixels are not drawn.
  double radius_clip = 0;

  template <class Real>
  PixelRules<Real> pixel_rules() const {
    PixelRules<Real> rules;
    rules.alpha_max = static_cast<Real>(alpha_max);
    rules.alpha_max_passes = alpha_max_passes;
    if (stops_at_equal) rules.stops_below = std::nextafter(rules.stops_below, Real(1));
    return rules;
  }
};

/// A view that the passes draw.
struct DrawnView {
  Camera camera;  ///< the rules replace its near plane
  /// Position of the camera in the world, from which colours are seen. Unset: camera.position().
  std::optional<glm::dvec3> position;
  Rules rules;
  CullMode mode = default_mode();
  int sh_degree = kMaxShDegree;  ///< highest evaluated degree, 0..3

  /// Throws Error(usage), in a sentence that starts with `who`.
  void check(const char* who) const;
};

/// The rules and the camera as project() and the gradients of kernel/ read them: this type has the
/// members of FootprintRules and of GradientRules. Kernels take it by value.
template <class Real>
struct PassRules {
  View<Real> view;
  SlopeLimits<Real> limits;
  Real far_depth, dilation, splat_scale, compensation_floor;
  static constexpr bool is_solid = false;
  static constexpr float solid_above = 0;
  bool antialiased, keep_faint, zero_color_passes, normalises_rotations;
  int sh_degree;
  RadiusRule radius_rule;
  double radius_clip;
  int width, height;  ///< px

  /// `sh_degree` of the Gaussians.
  static PassRules of(const DrawnView& drawn, int sh_degree);

  QS_HD bool draws_depth(const View<Real>& of, Real z) const {
    return z > of.near_depth && z <= far_depth;
  }
  QS_HD const SlopeLimits<Real>& slope_limits(const View<Real>&) const { return limits; }
};

}  // namespace qs::diff
