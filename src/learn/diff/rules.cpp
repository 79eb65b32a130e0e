// SPDX-License-Identifier: MIT
#include "learn/diff/rules.h"

#include <algorithm>

#include "base/fail.h"

namespace qs::diff {
namespace {

constexpr int kLargestSide = 32768;  // px; pixels are counted in 32 bits

}  // namespace

void DrawnView::check(const char* who) const {
  const auto require = [who](bool holds, const char* what) {
    if (!holds) fail(ErrorKind::usage, "{}: {}", who, what);
  };
  if (camera.width < 1 || camera.height < 1 || camera.width > kLargestSide ||
      camera.height > kLargestSide) {
    fail(ErrorKind::usage, "{}: the picture has {} x {} pixels; both sides must be 1 to {}", who,
         camera.width, camera.height, kLargestSide);
  }
  const auto& m = camera.view_from_world;
  double sum = camera.center_px.x + camera.center_px.y;
  for (int column = 0; column < 4; ++column) sum += m[column][0] + m[column][1] + m[column][2];
  if (position) sum += position->x + position->y + position->z;
  require(std::isfinite(sum), "the camera has a number that is not finite");
  require(camera.focal_px.x > 0 && camera.focal_px.y > 0 && std::isfinite(camera.focal_px.x) &&
              std::isfinite(camera.focal_px.y),
          "focal lengths must be above 0");
  require(mode >= 1 && mode <= mode_count(), "the culling mode must be a mode that lists tiles");
  require(sh_degree >= 0 && sh_degree <= kMaxShDegree, "the degree of colour must be 0 to 3");
  require(rules.near_depth >= 0, "the near plane must be at 0 or in front of the camera");
  require(rules.far_depth > rules.near_depth, "the far plane must be behind the near plane");
  require(rules.dilation >= 0 && std::isfinite(rules.dilation), "the dilation must be 0 or more");
  require(rules.splat_scale > 0 && std::isfinite(rules.splat_scale),
          "the scale of splats must be above 0");
  require(rules.compensation_floor >= 0 && rules.compensation_floor <= 1,
          "the lower bound of the compensation must be 0 to 1");
  require(rules.alpha_max > 0 && static_cast<float>(rules.alpha_max) < 1,
          "the largest alpha must be above 0 and below 1");
  require(rules.radius_clip >= 0, "the smallest radius must be 0 or more");
  if (rules.slopes) {
    const SlopeBounds& s = *rules.slopes;
    require(s.low.x <= s.high.x && s.low.y <= s.high.y, "a bound of slopes is above its upper one");
  }
}

template <class Real>
PassRules<Real> PassRules<Real>::of(const DrawnView& drawn, int sh_degree) {
  const Rules& rules = drawn.rules;
  PassRules<Real> result;
  result.view = make_view<Real>(drawn.camera);
  result.view.near_depth = static_cast<Real>(rules.near_depth);
  if (drawn.position) result.view.position = glm::vec<3, Real>(*drawn.position);
  result.limits = SlopeLimits<Real>::of(result.view);
  if (rules.slopes) {
    result.limits = {glm::vec<2, Real>(rules.slopes->low), glm::vec<2, Real>(rules.slopes->high)};
  }
  result.far_depth = static_cast<Real>(rules.far_depth);
  result.dilation = static_cast<Real>(rules.dilation);
  result.splat_scale = static_cast<Real>(rules.splat_scale);
  result.compensation_floor = static_cast<Real>(rules.compensation_floor);
  result.antialiased = rules.antialiased;
  result.keep_faint = row_of(drawn.mode).keeps_faint;
  result.zero_color_passes = rules.zero_color_passes;
  result.normalises_rotations = rules.normalises_rotations;
  result.sh_degree = std::min(drawn.sh_degree, sh_degree);
  result.radius_rule = rules.radius_rule;
  result.radius_clip = rules.radius_clip;
  result.width = drawn.camera.width;
  result.height = drawn.camera.height;
  return result;
}

template struct PassRules<float>;
template struct PassRules<double>;

}  // namespace qs::diff
