// SPDX-License-Identifier: MIT
//
// Projects a Gaussian to its footprint, or rejects it. Every backend decides with project() or a
// bit-equal copy of it. Culling modes read nothing but the footprint.
#pragma once

#include "raster/kernel/project.h"

namespace qs {

/// The geometry of a Gaussian, activated at upload.
struct ActiveGaussian {
  glm::vec3 position;             ///< world
  Covariance3<float> covariance;  ///< world units^2
  float log2_255_opacity;         ///< -inf if the opacity is 0; computed on the host
};

struct FootprintRules {
  bool keep_faint;    ///< keep Gaussians with opacity <= 1/255 (mode 3dgs)
  bool antialiased;   ///< scale the opacity by compensation()
  float splat_scale;  ///< factor on every standard deviation; 1 = as trained
  float dilation = static_cast<float>(kDilation);  ///< px^2 added to both variances, see dilate()
  bool is_solid = false;                           ///< draw solid ellipses, see kSolidLog2
  float solid_above = 0;  ///< log2 of 255 times the opacity above which they are drawn

  // The rules that renderers do not change.
  static constexpr float compensation_floor = static_cast<float>(kCompensationFloor);
  static QS_HD bool draws_depth(const View<float>& view, float depth) {
    return depth > view.near_depth;
  }
  static QS_HD SlopeLimits<float> slope_limits(const View<float>& view) {
    return SlopeLimits<float>::of(view);
  }
};

/// The footprint of a dilated covariance, px^2, whose determinant must be > 0. `gamma` is 2 ln(255
/// opacity). Uses only + - * /, so that all backends get the same bits.
QS_HD Footprint make_footprint(glm::vec2 mean_px, const Covariance2<float>& covariance,
                               float gamma) {
  const float determinant = covariance.determinant();
  return {mean_px, covariance,
          glm::vec3(covariance.yy / determinant, -covariance.xy / determinant,
                    covariance.xx / determinant),
          determinant, gamma};
}

struct Projected {
  Footprint footprint;
  float depth;           ///< see depth_of()
  float opacity_factor;  ///< 1 unless antialiased
};

/// Sets `out`. False if the Gaussian is at a depth that is not drawn, degenerate, not finite or too
/// faint. `Rules` has the members of FootprintRules.
template <class Rules = FootprintRules>
QS_HD bool project(const View<float>& view, const Rules& rules, const ActiveGaussian& gaussian,
                   Projected& out) {
  const glm::vec3 in_view = to_view(view, gaussian.position);
  out.depth = depth_of(view, in_view);
  if (!rules.draws_depth(view, out.depth)) return false;
  const glm::vec3 point = projected_point(view, in_view);
  const SlopeLimits<float> limits = rules.slope_limits(view);
  Covariance2<float> covariance = project_covariance(view, limits, point, gaussian.covariance);
  const float scale2 = rules.splat_scale * rules.splat_scale;
  covariance.xx = covariance.xx * scale2;
  covariance.xy = covariance.xy * scale2;
  covariance.yy = covariance.yy * scale2;
  const float before = covariance.determinant();
  dilate(view, limits, point, float{rules.dilation}, covariance);
  const float determinant = covariance.determinant();
  if (!(determinant > 0.0f) || !(determinant < INFINITY)) return false;
  float log2_255_opacity = gaussian.log2_255_opacity;
  out.opacity_factor = 1.0f;
  if (rules.antialiased) {
    out.opacity_factor = compensation(before, determinant, float{rules.compensation_floor});
    log2_255_opacity = log2_255_opacity + log2_portable(out.opacity_factor);
  }
  if (rules.is_solid) {
    if (!(log2_255_opacity > rules.solid_above)) return false;
    log2_255_opacity = kSolidLog2 + kLog2Of255;
  }
  const float gamma = 2.0f * static_cast<float>(kLn2) * log2_255_opacity;
  if (!rules.keep_faint && !(gamma > 0.0f)) return false;
  out.footprint = make_footprint(to_pixel(view, point), covariance, gamma);
  const float sum = out.footprint.mean_px.x + out.footprint.mean_px.y + out.footprint.conic.x +
                    out.footprint.conic.y + out.footprint.conic.z;
  return sum - sum == 0.0f;  // finite
}

}  // namespace qs
