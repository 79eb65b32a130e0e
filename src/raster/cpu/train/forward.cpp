// SPDX-License-Identifier: MIT
#include "raster/cpu/train/forward.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include <glm/geometric.hpp>

#include "raster/cpu/train/field_pass.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/composite.h"
#include "raster/kernel/cull/in_view.h"
#include "raster/kernel/cull/modes.h"
#include "raster/kernel/gradient/gaussian.h"
#include "raster/kernel/sh.h"
#include "raster/scene/activated_cloud.h"

namespace qs::cpu::train {
namespace {

// A Gaussian with activated parameters.
template <class Real>
struct WorldGaussian {
  const glm::vec<3, Real>& mean;
  Covariance3<double> sigma;
  double opacity;
};

// The input of the pixels. `projected` has decided that the Gaussian is visible; in double
// precision its values are computed again.
template <class Real>
typename PixelMath<Real>::Splat splat_of(const View<Real>& view, const StepView& step,
                                         const WorldGaussian<Real>& gaussian,
                                         const Projected& projected,
                                         const glm::vec<3, Real>& color) {
  if constexpr (std::is_same_v<Real, float>) {
    return make_splat(projected.footprint,
                      static_cast<float>(gaussian.opacity) * projected.opacity_factor, color);
  } else {
    const glm::dvec3 point = to_view(view, gaussian.mean);
    const auto covariance =
        ImageCovariance<double>::of(view, point, gaussian.sigma, step.settings.dilation);
    const Covariance2<double>& c = covariance.after;
    const double determinant = c.determinant();
    double opacity = gaussian.opacity;
    if (step.antialiased()) opacity *= compensation(covariance.before.determinant(), determinant);
    constexpr double kScale = -0.5 * kLog2E;
    return {to_pixel(view, point), glm::dvec3(c.yy, -2 * c.xy, c.xx) * (kScale / determinant),
            opacity, color};
  }
}

template <class Real, class P>
void project_all(const StepView& step, const FrameContext& context,
                 const Parameters<Real>& parameters, const FieldGradient<Real>* field,
                 ForwardFrame<Real>& frame) {
  VisibleSlots& visible = frame.visible;
  visible.resize(parameters.size());
  visible.footprints.resize(visible.slots());
  frame.splats.resize(visible.slots());
  frame.areas.resize(visible.slots());
  frame.in_view.assign(parameters.size(), 0);
  frame.listed.assign(parameters.size(), 0);
  const auto rounded_view = make_view<float>(step.camera);
  const auto view = make_view<Real>(step.camera);
  const FootprintRules rules = context.rules();
  const int degree = context.sh_degree();
  const std::size_t stride = parameters.sh_stride();

  context.for_chunks(
      parameters.size(), VisibleSlots::kChunk, [&](std::size_t begin, std::size_t end, int) {
        std::size_t slot = begin;
        for (std::size_t i = begin; i < end; ++i) {
          if (parameters.is_masked_out(i)) continue;
          // Activate and project.
          const glm::vec<3, Real>& mean = parameters.means[i];
          const Covariance3<double> sigma =
              covariance_of(glm::dvec3(parameters.log_scales[i]),
                            unit_rotation(glm::dquat(parameters.rotations[i])));
          const double opacity = opacity_of(static_cast<double>(parameters.opacity_logits[i]));
          Projected projected;
          if (!project(rounded_view, rules, activate(glm::vec3(mean), sigma, opacity).gaussian,
                       projected))
            continue;
          frame.in_view[i] = is_in_view(projected.footprint, context.grid);
          // Drop Gaussians without tiles.
          if (count_tiles<P>(projected.footprint, context.grid) == 0) continue;
          frame.listed[i] = 1;
          // Evaluate the colour and store the Gaussian in the next slot.
          const glm::vec<3, Real>* sh = &parameters.sh[i * stride];
          const auto color = field != nullptr
                                 ? field_color(*field, mean, view.position)
                                 : sh_color<Real>(degree, glm::normalize(mean - view.position),
                                                  [sh](int k) { return sh[k]; });
          visible.gaussians[slot] = static_cast<std::uint32_t>(i);
          visible.depths[slot] = projected.depth;
          visible.footprints[slot] = projected.footprint;
          frame.areas[slot] = PixelArea::of(projected.footprint);
          frame.splats[slot] = splat_of<Real>(view, step, {mean, sigma, opacity}, projected, color);
          ++slot;
        }
        visible.chunk_counts[begin / VisibleSlots::kChunk] =
            static_cast<std::uint32_t>(slot - begin);
      });
  visible.count_all();
}

template <class Real>
void blend_tile(const StepView& step, std::size_t tile, ForwardFrame<Real>& frame) {
  using Vec3 = glm::vec<3, Real>;
  constexpr auto kPixels = static_cast<std::size_t>(kTileSize * kTileSize);
  const TileBox box = TileBox::of(step, tile);
  std::array<Vec3, kPixels> color;
  std::array<Real, kPixels> transmittance;
  std::array<std::uint32_t, kPixels> last{};
  std::array<bool, kPixels> live;
  color.fill(Vec3(0));
  transmittance.fill(1);
  live.fill(true);

  // Composite the list front to back until all pixels have stopped.
  int left = box.width * box.height;
  const std::uint32_t length = frame.lists.pairs(tile);
  const std::uint32_t* list = frame.lists.slots.data() + frame.lists.begin[tile];
  for (std::uint32_t entry = 0; entry < length && left > 0; ++entry) {
    const auto& splat = frame.splats[list[entry]];
    box.for_each_pixel(frame.areas[list[entry]], [&](int x, int y, int pixel) {
      const auto p = static_cast<std::size_t>(pixel);
      if (!live[p]) return;
      const Real in_front = transmittance[p];
      Real alpha = 0;
      switch (
          composite(splat, static_cast<Real>(x), static_cast<Real>(y), transmittance[p], alpha)) {
        case Step::skips:
          break;
        case Step::blends:
          color[p] += alpha * in_front * splat.color;
          last[p] = entry + 1;
          break;
        case Step::stops:
          live[p] = false;
          --left;
          break;
      }
    });
  }

  // Add the background and store the pixels.
  const Vec3 background(step.settings.background);
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const auto p = static_cast<std::size_t>(y * kTileSize + x);
      const auto at = static_cast<std::size_t>((box.y0 + y) * step.camera.width + box.x0 + x);
      frame.color[at] = color[p] + transmittance[p] * background;
      frame.transmittance[at] = transmittance[p];
      frame.last[at] = last[p];
    }
  }
}

}  // namespace

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

TileBox TileBox::of(const StepView& view, std::size_t tile) {
  const int columns = view.grid().columns;
  const int x0 = static_cast<int>(tile) % columns * kTileSize;
  const int y0 = static_cast<int>(tile) / columns * kTileSize;
  return {x0, y0, std::min(kTileSize, view.camera.width - x0),
          std::min(kTileSize, view.camera.height - y0)};
}

template <class Real>
void forward(const StepView& view, const Parameters<Real>& parameters, ForwardFrame<Real>& frame,
             const FieldGradient<Real>* field) {
  // The stages below read nothing else of a cloud.
  GaussianCloud facts;
  facts.sh_degree = parameters.sh_degree;
  facts.antialiased = view.antialiased();
  const FrameContext context{facts, view.camera, view.settings, view.grid(), view.pool, view.stop};
  with_culler(view.settings.mode,
              [&]<class P>(P) { project_all<Real, P>(view, context, parameters, field, frame); });
  sort(context, frame.visible, frame.order);
  bin(context, frame.visible, frame.order, frame.lists);

  const auto pixels = static_cast<std::size_t>(view.camera.width * view.camera.height);
  frame.color.resize(pixels);
  frame.transmittance.resize(pixels);
  frame.last.resize(pixels);
  context.for_chunks(static_cast<std::size_t>(context.grid.count()), 1,
                     [&](std::size_t begin, std::size_t end, int) {
                       for (std::size_t tile = begin; tile < end; ++tile)
                         blend_tile(view, tile, frame);
                     });
}

template void forward(const StepView&, const Parameters<float>&, ForwardFrame<float>&,
                      const FieldGradient<float>*);
template void forward(const StepView&, const Parameters<double>&, ForwardFrame<double>&,
                      const FieldGradient<double>*);

}  // namespace qs::cpu::train
