// SPDX-License-Identifier: MIT
//
// Checks of the inputs of all passes, and the rules of a pass.
#include <algorithm>
#include <limits>

#include "base/fail.h"
#include "learn/diff/gaussians.h"
#include "learn/diff/rules.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::diff {

template <class Real>
void GaussianInputs<Real>::check(const char* who) const {
  const auto require = [who](bool holds, const char* what) {
    if (!holds) fail(ErrorKind::usage, "{}: {}", who, what);
  };
  require(count <= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()),
          "there are more than 2^31 - 1 Gaussians");
  require(channel_count >= 1 && channel_count <= kMostChannels,
          "the number of channels must be 1 to 32");
  require(sh_degree >= 0 && sh_degree <= kMaxShDegree,
          "the degree of the coefficients of colour must be 0 to 3");
  if (count == 0) return;
  require(means && opacities, "means and opacities are missing");
  require(covariances ? !scales && !rotations : scales && rotations,
          "either covariances or both scales and rotations must be given");
  require(static_cast<bool>(sh) != static_cast<bool>(channels),
          "either coefficients of colour or channels must be given");
  require(!sh || sh_degree == 0 || sh.rest, "the coefficients of colour beyond DC are missing");
  require(!sh || channel_count == 3, "coefficients of colour give 3 channels");
}

template <class Real>
void GaussianInputs<Real>::check_frame(const char* who, std::size_t of_frame) const {
  if (of_frame == count) return;
  fail(ErrorKind::usage, "{}: the frame has {} Gaussians, the inputs have {}", who, of_frame,
       count);
}

template <class Real>
void BlendInput<Real>::check(const char* who, bool has_depth, bool wants_depth) const {
  if (channel_count < 1 || channel_count > kMostChannels)
    fail(ErrorKind::usage, "{}: there are {} channels; the number must be 1 to {}", who,
         channel_count, kMostChannels);
  if (!channels && channel_count != 3)
    fail(ErrorKind::usage, "{}: the frame's colours have 3 channels, not {}", who, channel_count);
  if (wants_depth && !has_depth)
    fail(ErrorKind::usage, "{}: depths are wanted, but the frame has no arrays for them", who);
}

template <class Real>
void BlendInput<Real>::check_frame(const char* who, const PictureSize& of_frame,
                                   int channels_of_frame) const {
  if (size.width == of_frame.width && size.height == of_frame.height &&
      channel_count == channels_of_frame)
    return;
  fail(ErrorKind::usage, "{}: the frame has {} x {} pixels and {} channels, not {} x {} and {}",
       who, of_frame.width, of_frame.height, channels_of_frame, size.width, size.height,
       channel_count);
}

void DrawnView::check(const char* who) const {
  constexpr int kLargestSide = 32768;  // px; pixels are counted in 32 bits
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
  if (rules.slopes)
    result.limits = {glm::vec<2, Real>(rules.slopes->low), glm::vec<2, Real>(rules.slopes->high)};
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

template struct GaussianInputs<float>;
template struct GaussianInputs<double>;
template struct BlendInput<float>;
template struct BlendInput<double>;
template struct PassRules<float>;
template struct PassRules<double>;

}  // namespace qs::diff
