// SPDX-License-Identifier: MIT
#include "learn/diff/cpu/project.h"

#include <vector>

#include "learn/diff/cpu/project_gaussians.h"
#include "learn/diff/gaussian_terms.h"
#include "raster/cpu/common/tile_lists.h"
#include "raster/kernel/cull/modes.h"

namespace qs::cpu::diff {
namespace {

constexpr std::size_t kGaussianGrain = 4096;

/// Writes the gradients of all Gaussians. Chunks have sums of their own for the pose, which are
/// added in the order of chunks.
template <class Real>
PoseGradient set_gradients(const GivenGradient<Real>& gradient, const Boundary<const Real>& by,
                           std::span<const std::uint8_t> projected, const Workers& workers) {
  constexpr std::size_t kChunk = VisibleSlots::kChunk;
  std::vector<PoseGradient> sums(VisibleSlots::chunks_of(projected.size()));
  workers.for_each(sums.size(), 1, [&](std::size_t chunk) {
    const std::size_t end = std::min(projected.size(), (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i) {
      const auto d = BoundaryGradient<Real>::of(by, i);
      if (projected[i] != 0 && !d.is_zero())
        gradient.add(i, d, sums[chunk]);
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

}  // namespace

CountTiles tile_counter(CullMode mode) {
  return with_culler(mode, []<class P>(P) -> CountTiles {
    return
        [](const Footprint& footprint, TileGrid grid) { return count_tiles<P>(footprint, grid); };
  });
}

PixelArea PixelArea::of(const Footprint& footprint) {
  // The slack covers the rounding of the falloff, as in pipeline `classic`.
  const PixelBound bound = PixelBound::of(footprint);
  return {footprint.mean_px,
          bound.half,
          bound.slope,
          footprint.gamma > 0 ? bound.threshold / kLog2OfFalloff : 0,
          1 / footprint.covariance.yy,
          1 / footprint.conic.x};
}

template <class Real>
void project(const DrawnView& view, const GaussianInputs<Real>& gaussians, const Workers& workers,
             ProjectedFrame<Real>& frame, const Boundary<Real>& out,
             const Rows<std::int32_t>& radii) {
  view.check("project");
  gaussians.check("project");
  const auto single = PassRules<float>::of(view, gaussians.sh_degree);
  const auto rules = PassRules<Real>::of(view, gaussians.sh_degree);
  // The steps below read nothing else of a cloud and of settings.
  const GaussianCloud cloud;
  RenderSettings settings;
  settings.mode = view.mode;
  const TileGrid grid = TileGrid::of_image(view.camera.width, view.camera.height);
  const FrameContext context{cloud, view.camera, settings, grid, workers.pool, workers.stop};
  const GivenGaussians<Real> source{rules, gaussians, out, radii};
  workers.for_each(gaussians.count, kGaussianGrain, [&](std::size_t i) { source.clear(i); });
  project_gaussians<Real>(context, single.view, single, rules, source, gaussians.count, frame);
  list_gaussians(context, frame);
}

template <class Real>
void project_backward(const DrawnView& view, const GaussianInputs<Real>& gaussians,
                      std::span<const std::uint8_t> projected, const Boundary<const Real>& by,
                      const Workers& workers, const InputGradients<Real>& out, PoseGradient* pose) {
  view.check("project_backward");
  gaussians.check("project_backward");
  gaussians.check_frame("project_backward", projected.size());
  const auto rules = PassRules<Real>::of(view, gaussians.sh_degree);
  const GivenGradient<Real> gradient(rules, gaussians, out);
  const PoseGradient sum = set_gradients(gradient, by, projected, workers);
  if (pose != nullptr) *pose = sum;
}

template decltype(project<float>) project<float>;
template decltype(project<double>) project<double>;
template decltype(project_backward<float>) project_backward<float>;
template decltype(project_backward<double>) project_backward<double>;

}  // namespace qs::cpu::diff
