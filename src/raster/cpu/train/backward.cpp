// SPDX-License-Identifier: MIT
#include "raster/cpu/train/backward.h"

#include <algorithm>
#include <array>

#include <glm/geometric.hpp>

#include "raster/kernel/activation.h"
#include "raster/kernel/composite.h"
#include "raster/kernel/gradient/activation.h"
#include "raster/kernel/gradient/footprint.h"
#include "raster/kernel/gradient/project.h"
#include "raster/kernel/gradient/sh.h"
#include "raster/kernel/sh.h"

namespace qs::cpu::train {
namespace {

// Composites the tile front to back again. A pixel knows its final colour, so the colour that is
// still to come is the difference to the colour so far.
template <class Real>
void tile_gradients(const StepView& step, const ForwardFrame<Real>& frame,
                    std::span<const glm::vec<3, Real>> d_color, std::size_t tile,
                    std::vector<PixelSums<Real>>& pairs) {
  using Vec3 = glm::vec<3, Real>;
  constexpr auto kPixels = static_cast<std::size_t>(kTileSize * kTileSize);
  const TileBox box = TileBox::of(step, tile);
  std::array<Vec3, kPixels> to_come, d_pixel;
  std::array<Real, kPixels> transmittance;
  std::array<std::uint32_t, kPixels> last{};
  transmittance.fill(1);
  std::uint32_t longest = 0;
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const auto p = static_cast<std::size_t>(y * kTileSize + x);
      const auto at = static_cast<std::size_t>((box.y0 + y) * step.camera.width + box.x0 + x);
      to_come[p] = frame.color[at];
      d_pixel[p] = d_color[at];
      last[p] = frame.last[at];
      longest = std::max(longest, last[p]);
    }
  }

  const std::uint64_t first = frame.lists.begin[tile];
  for (std::uint32_t entry = 0; entry < longest; ++entry) {
    const std::uint32_t slot = frame.lists.slots[first + entry];
    const auto& splat = frame.splats[slot];
    PixelSums<Real> sums;
    box.for_each_pixel(frame.areas[slot], [&](int px, int py, int pixel) {
      const auto p = static_cast<std::size_t>(pixel);
      if (entry >= last[p]) return;
      const auto x = static_cast<Real>(px), y = static_cast<Real>(py);
      const Real in_front = transmittance[p];
      Real alpha = 0;
      if (composite(splat, x, y, transmittance[p], alpha) != Step::blends) return;
      to_come[p] -= alpha * in_front * splat.color;
      add_pixel<Real>(splat, x, y, alpha, in_front, to_come[p], d_pixel[p], sums);
    });
    pairs[first + entry] = sums;
  }
  std::fill(pairs.begin() + static_cast<std::ptrdiff_t>(first + longest),
            pairs.begin() + static_cast<std::ptrdiff_t>(frame.lists.begin[tile + 1]),
            PixelSums<Real>{});
}

// Lists the pairs of every slot. Pairs are visited by tile, so each list is in the order of tiles.
template <class Real>
void order_by_slot(const ForwardFrame<Real>& frame, BackwardScratch<Real>& scratch) {
  const auto& slots = frame.lists.slots;
  scratch.begin.assign(frame.visible.slots() + 1, 0);
  for (const std::uint32_t slot : slots) ++scratch.begin[slot + 1];
  for (std::size_t slot = 0; slot < frame.visible.slots(); ++slot)
    scratch.begin[slot + 1] += scratch.begin[slot];
  scratch.order.resize(slots.size());
  std::vector<std::uint64_t> next(scratch.begin.begin(), scratch.begin.end() - 1);
  for (std::uint64_t pair = 0; pair < slots.size(); ++pair)
    scratch.order[next[slots[pair]]++] = pair;
}

// From the values that pixels read of Gaussian i to its parameters.
template <class Real>
void gaussian_gradient(const StepView& step, const View<Real>& view, int degree,
                       const Parameters<Real>& parameters, std::size_t i,
                       const SplatGradient<Real>& splat, Gradients<Real>& gradients) {
  using Vec3 = glm::vec<3, Real>;
  const Vec3& mean = parameters.means[i];
  const Vec3& log_scale = parameters.log_scales[i];
  const glm::qua<Real>& rotation = parameters.rotations[i];
  const Covariance3<Real> sigma = covariance_of(log_scale, unit_rotation(rotation));
  const Vec3 point = to_view(view, mean);
  const auto covariance = ImageCovariance<Real>::of(view, point, sigma, step.settings.dilation);

  const Real opacity = opacity_of(parameters.opacity_logits[i]);
  Real d_opacity = splat.opacity;
  Covariance2<Real> d_covariance = conic_gradient(covariance.after, splat.conic);
  if (step.antialiased()) {
    const Real factor =
        compensation(covariance.before.determinant(), covariance.after.determinant());
    const Covariance2<Real> more =
        compensation_gradient(covariance.before, covariance.after, splat.opacity * opacity);
    d_covariance.xx += more.xx;
    d_covariance.xy += more.xy;
    d_covariance.yy += more.yy;
    d_opacity *= factor;
  }
  gradients.by.opacity_logits[i] = opacity_gradient(opacity, d_opacity);

  const GeometryGradient<Real> geometry =
      project_covariance_gradient(view, point, sigma, d_covariance);
  const ShapeGradient<Real> shape = covariance_gradient(log_scale, rotation, geometry.covariance);
  gradients.by.log_scales[i] = shape.log_scale;
  gradients.by.rotations[i] = shape.rotation;
  Vec3 d_mean = view_gradient(view, geometry.mean + pixel_gradient(view, point, splat.mean_px));

  const Vec3 offset = mean - view.position;
  const Vec3 direction = glm::normalize(offset);
  const Vec3* sh = &parameters.sh[i * parameters.sh_stride()];
  Vec3* d_sh = &gradients.by.sh[i * parameters.sh_stride()];
  const auto coefficients = [sh](int k) { return sh[k]; };
  const Vec3 color = sh_color<Real>(degree, direction, coefficients);
  const Vec3 d_direction =
      sh_gradient(degree, direction, coefficients, clamp_gradient(color, splat.color),
                  [d_sh](int k, const Vec3& gradient) { d_sh[k] = gradient; });
  gradients.by.means[i] = d_mean + direction_gradient(offset, d_direction);
  gradients.mean_px[i] = splat.mean_px;
}

}  // namespace

template <class Real>
void backward(const StepView& view, const Parameters<Real>& parameters,
              const ForwardFrame<Real>& frame, std::span<const glm::vec<3, Real>> d_color,
              BackwardScratch<Real>& scratch, Gradients<Real>& gradients) {
  const auto for_chunks = [&](std::size_t count, std::size_t grain, const auto& each) {
    view.pool.for_chunks(count, grain, [&](std::size_t begin, std::size_t end, int) {
      if (view.stop.stop_requested()) throw Cancelled{};
      for (std::size_t i = begin; i < end; ++i) each(i);
    });
  };
  scratch.pairs.resize(frame.lists.pairs());
  for_chunks(static_cast<std::size_t>(view.grid().count()), 1,
             [&](std::size_t tile) { tile_gradients(view, frame, d_color, tile, scratch.pairs); });
  order_by_slot(frame, scratch);

  gradients.reset(parameters);
  gradients.visible = frame.in_view;
  const auto kernel_view = make_view<Real>(view.camera);
  const int degree = std::min(view.settings.sh_degree, parameters.sh_degree);
  const VisibleSlots& visible = frame.visible;
  for_chunks(visible.chunk_counts.size(), 1, [&](std::size_t chunk) {
    for (std::uint32_t k = 0; k < visible.chunk_counts[chunk]; ++k) {
      const std::size_t slot = chunk * VisibleSlots::kChunk + k;
      PixelSums<Real> sums;
      for (std::uint64_t at = scratch.begin[slot]; at < scratch.begin[slot + 1]; ++at)
        sums += scratch.pairs[scratch.order[at]];
      gaussian_gradient(view, kernel_view, degree, parameters, visible.gaussians[slot],
                        splat_gradient<Real>(frame.splats[slot], sums), gradients);
    }
  });
}

template void backward(const StepView&, const Parameters<float>&, const ForwardFrame<float>&,
                       std::span<const glm::vec3>, BackwardScratch<float>&, Gradients<float>&);
template void backward(const StepView&, const Parameters<double>&, const ForwardFrame<double>&,
                       std::span<const glm::dvec3>, BackwardScratch<double>&, Gradients<double>&);

}  // namespace qs::cpu::train
