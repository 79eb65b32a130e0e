// SPDX-License-Identifier: MIT
#include "raster/cpu/stages/project.h"

#include <algorithm>
#include <vector>

#include <glm/geometric.hpp>

#include "raster/base/fail.h"
#include "raster/cpu/stages/project_gaussians.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/gradient/sh.h"
#include "raster/kernel/sh.h"

namespace qs::cpu::stages {
namespace {

using qs::stages::StageRules;

constexpr std::size_t kGaussianGrain = 4096;

bool finite(double value) { return value - value == 0; }

template <class Real>
bool finite(const Rows<const Real>& rows, std::size_t i, int numbers) {
  bool all = true;
  for (int k = 0; k < numbers && rows; ++k) all = all && finite(static_cast<double>(rows.at(i, k)));
  return all;
}

template <class T>
Covariance3<T> covariance_at(const auto& rows, std::size_t i) {
  const auto at = [&](int k) { return static_cast<T>(rows.at(i, k)); };
  return {at(0), at(1), at(2), at(3), at(4), at(5)};
}

/// Gaussians in the caller's arrays.
template <class Real>
struct GivenGaussians {
  static constexpr bool kReports = true;

  const DrawnView& drawn;
  const StageRules<Real>& rules;
  const GaussianInputs<Real>& in;
  const Boundary<Real>& out;
  const Rows<std::int32_t>& radii;

  bool exists(std::size_t i) const {
    bool all = finite(in.means, i, 3) && finite(in.scales, i, 3) && finite(in.rotations, i, 4) &&
               finite(in.covariances, i, 6) && finite(in.opacities, i, 1) &&
               finite(in.channels, i, in.channel_count);
    const int coefficients = in.sh ? sh_coefficient_count(rules.sh_degree) : 0;
    for (int k = 0; k < coefficients; ++k) {
      for (int c = 0; c < 3; ++c) all = all && finite(static_cast<double>(in.sh.at(i, k, c)));
    }
    return all;
  }
  glm::vec<3, Real> mean(std::size_t i) const { return in.means.vec3(i); }
  double opacity(std::size_t i) const { return static_cast<double>(in.opacities.at(i)); }
  Covariance3<double> covariance(std::size_t i) const {
    if (in.covariances) return covariance_at<double>(in.covariances, i);
    const glm::dquat rotation(in.rotations.quaternion(i));
    return scaled_covariance(glm::dvec3(in.scales.vec3(i)),
                             drawn.rules.normalises_rotations ? unit_rotation(rotation) : rotation);
  }
  glm::vec<3, Real> color(std::size_t i, const glm::vec<3, Real>& mean) const {
    if (!in.sh) return glm::vec<3, Real>(0);
    return sh_color<Real>(rules.sh_degree, glm::normalize(mean - rules.view.position),
                          [&](int k) { return in.sh.vec3(i, k); });
  }

  bool report(std::size_t i, const Projected& projected, const SplatValues<Real>& values,
              const glm::vec<3, Real>& color) const {
    if (!finite(static_cast<double>(color.x + color.y + color.z))) return false;
    if (radii || drawn.rules.radius_clip > 0) {
      const glm::ivec2 found =
          radii_of(drawn.rules.radius_rule, projected.footprint, static_cast<float>(values.opacity),
                   drawn.camera.width, drawn.camera.height);
      const double clip = drawn.rules.radius_clip;
      if (clip > 0 && found.x <= clip && found.y <= clip) return false;
      radii.set(i, found);
    }
    out.mean_px.set(i, values.mean_px);
    out.conic.set(i, values.conic);
    out.depth.set(i, values.depth);
    out.opacity.set(i, values.opacity);
    out.color.set(i, color);
    return true;
  }
};

/// The gradient of one Gaussian in the caller's arrays.
template <class Real>
struct GivenGradient {
  using Vec3 = glm::vec<3, Real>;

  const DrawnView& drawn;
  const StageRules<Real>& rules;
  const GaussianInputs<Real>& in;
  const Boundary<const Real>& by;
  const InputGradients<Real>& out;

  SplatGradient<Real> splat(std::size_t i) const {
    SplatGradient<Real> d;
    if (by.mean_px) d.mean_px = by.mean_px.vec2(i);
    if (by.conic) d.conic = by.conic.vec3(i);
    if (by.opacity) d.opacity = by.opacity.at(i);
    if (by.color) d.color = by.color.vec3(i);
    return d;
  }

  void clear(std::size_t i) const {
    out.means.fill(i, 3, 0);
    out.scales.fill(i, 3, 0);
    out.rotations.fill(i, 4, 0);
    out.covariances.fill(i, 6, 0);
    out.opacities.fill(i, 1, 0);
    if (out.sh) clear_coefficients(i, 0);
  }
  /// From coefficient `first` on.
  void clear_coefficients(std::size_t i, int first) const {
    for (int k = first; k < sh_coefficient_count(in.sh_degree); ++k) out.sh.set(i, k, Vec3(0));
  }

  /// Returns the derivative by the mean through the colour's direction.
  Vec3 color(std::size_t i, const Vec3& mean, const Vec3& d_color) const {
    if (out.sh) clear_coefficients(i, sh_coefficient_count(rules.sh_degree));
    if (!in.sh) return Vec3(0);
    const auto coefficients = [&](int k) { return in.sh.vec3(i, k); };
    const auto gradient = ColorGradient<Real>::of(rules, mean, coefficients, d_color);
    const Vec3 d_direction =
        sh_gradient<Real>(rules.sh_degree, gradient.direction, coefficients, gradient.by_color,
                          [&](int k, const Vec3& value) { out.sh.set(i, k, value); });
    return direction_gradient(mean - rules.view.position, d_direction);
  }

  void add(std::size_t i, PoseGradient& pose) const {
    const SplatGradient<Real> d = splat(i);
    const Real d_depth = by.depth ? by.depth.at(i) : Real(0);
    if (d.mean_px == glm::vec<2, Real>(0) && d.conic == Vec3(0) && d.opacity == 0 &&
        d.color == Vec3(0) && d_depth == 0) {
      clear(i);
      return;
    }
    const Vec3 mean = in.means.vec3(i);
    Vec3 scale(0);
    glm::qua<Real> rotation(1, 0, 0, 0), q = rotation;
    Covariance3<Real> sigma;
    if (in.covariances) {
      sigma = covariance_at<Real>(in.covariances, i);
    } else {
      scale = in.scales.vec3(i);
      rotation = in.rotations.quaternion(i);
      q = drawn.rules.normalises_rotations ? unit_rotation(rotation) : rotation;
      sigma = scaled_covariance(scale, q);
    }
    PlacedGradient<Real> placed =
        placed_gradient(rules, to_view(rules.view, mean), sigma, in.opacities.at(i), d);
    placed.geometry.mean.z += d_depth;
    const Vec3 by_direction = color(i, mean, d.color);

    out.means.set(i, view_gradient(rules.view, placed.geometry.mean) + by_direction);
    out.opacities.set(i, placed.opacity);
    const Covariance3<Real>& c = placed.geometry.covariance;
    if (in.covariances) {
      const Real values[] = {c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
      for (int k = 0; k < 6 && out.covariances; ++k) out.covariances.at(i, k) = values[k];
    } else {
      const auto shape = scaled_covariance_gradient(scale, q, c);
      const glm::qua<Real> r = drawn.rules.normalises_rotations
                                   ? unit_rotation_gradient(rotation, q, shape.rotation)
                                   : shape.rotation;
      out.scales.set(i, shape.scale);
      out.rotations.set(i, glm::vec<4, Real>(r.w, r.x, r.y, r.z));
    }

    const glm::dvec3 d_point(placed.geometry.mean), position(mean);
    for (int row = 0; row < 3; ++row) {
      const glm::dvec3 through_covariance(placed.geometry.rows[row]);
      for (int column = 0; column < 3; ++column) {
        pose.view_from_world[column][row] +=
            d_point[row] * position[column] + through_covariance[column];
      }
      pose.view_from_world[3][row] += d_point[row];
    }
    pose.position -= glm::dvec3(by_direction);
  }
};

/// Writes the gradients of all Gaussians. Chunks have sums of their own for the pose, which are
/// added in the order of chunks.
template <class Real>
PoseGradient set_gradients(const GivenGradient<Real>& gradient,
                           std::span<const std::uint8_t> projected, const Workers& workers) {
  constexpr std::size_t kChunk = VisibleSlots::kChunk;
  std::vector<PoseGradient> sums(VisibleSlots::chunks_of(projected.size()));
  workers.for_each(sums.size(), 1, [&](std::size_t chunk) {
    const std::size_t end = std::min(projected.size(), (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i) {
      if (projected[i] != 0)
        gradient.add(i, sums[chunk]);
      else
        gradient.clear(i);
    }
  });
  PoseGradient result;
  for (const PoseGradient& sum : sums) {
    result.view_from_world += sum.view_from_world;
    result.position += sum.position;
  }
  return result;
}

template <class Real>
void clear_rows(const GaussianInputs<Real>& gaussians, const Workers& workers,
                const Boundary<Real>& out, const Rows<std::int32_t>& radii) {
  workers.for_each(gaussians.count, kGaussianGrain, [&](std::size_t i) {
    out.mean_px.fill(i, 2, 0);
    out.conic.fill(i, 3, 0);
    out.depth.fill(i, 1, 0);
    out.opacity.fill(i, 1, 0);
    out.color.fill(i, 3, 0);
    radii.fill(i, 2, 0);
  });
}

}  // namespace

template <class Real>
void project(const DrawnView& view, const GaussianInputs<Real>& gaussians, const Workers& workers,
             ProjectedFrame<Real>& frame, const Boundary<Real>& out,
             const Rows<std::int32_t>& radii) {
  view.check("project");
  gaussians.check("project");
  clear_rows(gaussians, workers, out, radii);
  const auto single = StageRules<float>::of(view, gaussians.sh_degree);
  const auto rules = StageRules<Real>::of(view, gaussians.sh_degree);
  // The steps below read nothing else of a cloud and of settings.
  const GaussianCloud cloud;
  RenderSettings settings;
  settings.mode = view.mode;
  const TileGrid grid = TileGrid::of_image(view.camera.width, view.camera.height);
  const FrameContext context{cloud, view.camera, settings, grid, workers.pool, workers.stop};
  const GivenGaussians<Real> source{view, rules, gaussians, out, radii};
  project_gaussians<Real>(context, single.view, single, rules, source, gaussians.count, frame);
  list_gaussians(context, frame);
}

template <class Real>
void project_backward(const DrawnView& view, const GaussianInputs<Real>& gaussians,
                      std::span<const std::uint8_t> projected, const Boundary<const Real>& by,
                      const Workers& workers, const InputGradients<Real>& out, PoseGradient* pose) {
  view.check("project_backward");
  gaussians.check("project_backward");
  if (projected.size() != gaussians.count) {
    fail(ErrorKind::usage, "project_backward: the frame has {} Gaussians, the inputs have {}",
         projected.size(), gaussians.count);
  }
  const auto rules = StageRules<Real>::of(view, gaussians.sh_degree);
  // Inputs that are not given have no derivatives.
  InputGradients<Real> wanted = out;
  if (gaussians.covariances)
    wanted.scales = wanted.rotations = {};
  else
    wanted.covariances = {};
  if (!gaussians.sh) wanted.sh = {};
  const GivenGradient<Real> gradient{view, rules, gaussians, by, wanted};
  const PoseGradient sum = set_gradients(gradient, projected, workers);
  if (pose != nullptr) *pose = sum;
}

#define QS_INSTANTIATE(Real)                                                                      \
  template void project(const DrawnView&, const GaussianInputs<Real>&, const Workers&,            \
                        ProjectedFrame<Real>&, const Boundary<Real>&, const Rows<std::int32_t>&); \
  template void project_backward(const DrawnView&, const GaussianInputs<Real>&,                   \
                                 std::span<const std::uint8_t>, const Boundary<const Real>&,      \
                                 const Workers&, const InputGradients<Real>&, PoseGradient*)
QS_INSTANTIATE(float);
QS_INSTANTIATE(double);
#undef QS_INSTANTIATE

}  // namespace qs::cpu::stages
