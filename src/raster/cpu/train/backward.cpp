// SPDX-License-Identifier: MIT
#include "raster/cpu/train/backward.h"

#include <algorithm>
#include <array>

#include <glm/common.hpp>

#include "raster/cpu/train/field_pass.h"
#include "raster/kernel/composite.h"
#include "raster/kernel/gradient/gaussian.h"

namespace qs::cpu::train {
namespace {

// Composites the tile front to back again. The final colour of a pixel is known, so the colour of
// the Gaussians behind is the difference to the colour so far.
template <class Real>
void tile_gradients(const StepView& step, const ForwardFrame<Real>& frame,
                    std::span<const glm::vec<3, Real>> d_color, std::size_t tile,
                    BackwardScratch<Real>& scratch) {
  using Vec3 = glm::vec<3, Real>;
  constexpr auto kPixels = static_cast<std::size_t>(kTileSize * kTileSize);
  const TileBox box = TileBox::of(step, tile);
  std::array<Vec3, kPixels> to_come, d_pixel;
  std::array<Real, kPixels> transmittance;
  std::array<std::uint32_t, kPixels> last{};
  transmittance.fill(1);
  std::uint32_t longest = 0;
  // Load the pixels of the tile.
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

  // Composite again, and sum the gradients of each pair.
  const std::uint64_t first = frame.lists.begin[tile];
  for (std::uint32_t entry = 0; entry < longest; ++entry) {
    const std::uint32_t slot = frame.lists.slots[first + entry];
    const auto& splat = frame.splats[slot];
    PixelSums<Real> sums;
    glm::vec<2, Real> absolute(0);
    box.for_each_pixel(frame.areas[slot], [&](int px, int py, int pixel) {
      const auto p = static_cast<std::size_t>(pixel);
      if (entry >= last[p]) return;
      const auto x = static_cast<Real>(px), y = static_cast<Real>(py);
      const Real in_front = transmittance[p];
      Real alpha = 0;
      if (composite(splat, x, y, transmittance[p], alpha) != Step::blends) return;
      to_come[p] -= alpha * in_front * splat.color;
      absolute +=
          glm::abs(add_pixel<Real>(splat, {x, y, alpha, in_front, to_come[p], d_pixel[p]}, sums));
    });
    scratch.pairs[first + entry] = sums;
    if (!scratch.absolute.empty()) scratch.absolute[first + entry] = absolute;
  }
  // No pixel blends the rest of the list.
  const auto clear_rest = [&]<class Sums>(std::vector<Sums>& sums) {
    if (sums.empty()) return;
    std::fill(sums.begin() + static_cast<std::ptrdiff_t>(first + longest),
              sums.begin() + static_cast<std::ptrdiff_t>(frame.lists.begin[tile + 1]), Sums{});
  };
  clear_rest(scratch.pairs);
  clear_rest(scratch.absolute);
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

// The gradient of Gaussian i, from the values that pixels read to its parameters.
template <class Real>
void set_gradient(const GradientRules<Real>& rules, const Parameters<Real>& parameters,
                  std::size_t i, const SplatGradient<Real>& splat, Gradients<Real>& gradients) {
  const glm::vec<3, Real>* sh = &parameters.sh[i * parameters.sh_stride()];
  glm::vec<3, Real>* d_sh = &gradients.by.sh[i * parameters.sh_stride()];
  const GaussianValues<Real> gradient = gaussian_gradient<Real>(
      rules,
      {parameters.means[i], parameters.log_scales[i], parameters.rotations[i],
       parameters.opacity_logits[i], parameters.has_masks ? parameters.mask_logits[i] : Real{0}},
      [sh](int k) { return sh[k]; }, splat,
      [d_sh](int k, const glm::vec<3, Real>& by) { d_sh[k] = by; });
  gradients.by.means[i] = gradient.mean;
  gradients.by.log_scales[i] = gradient.log_scale;
  gradients.by.rotations[i] = gradient.rotation;
  gradients.by.opacity_logits[i] = gradient.opacity_logit;
  if (parameters.has_masks) gradients.by.mask_logits[i] = gradient.mask_logit;
  gradients.mean_px[i] = splat.mean_px;
}

}  // namespace

template <class Real>
void backward(const StepView& view, const Parameters<Real>& parameters,
              const ForwardFrame<Real>& frame, std::span<const glm::vec<3, Real>> d_color,
              BackwardScratch<Real>& scratch, Gradients<Real>& gradients,
              const BackwardOrder& order, const FieldGradient<Real>* field) {
  const auto for_chunks = [&](std::size_t count, std::size_t grain, const auto& each) {
    view.pool.for_chunks(count, grain, [&](std::size_t begin, std::size_t end, int) {
      if (view.stop.stop_requested()) throw Cancelled{};
      for (std::size_t i = begin; i < end; ++i) each(i);
    });
  };
  scratch.pairs.resize(frame.lists.pairs());
  scratch.absolute.resize(order.absolute ? frame.lists.pairs() : 0);
  for_chunks(static_cast<std::size_t>(view.grid().count()), 1,
             [&](std::size_t tile) { tile_gradients(view, frame, d_color, tile, scratch); });
  order_by_slot(frame, scratch);

  gradients.reset(parameters);
  gradients.absolute_px.assign(order.absolute ? parameters.size() : 0, glm::vec<2, Real>(0));
  gradients.visible = frame.in_view;
  const GradientRules<Real> rules{make_view<Real>(view.camera), view.settings.dilation,
                                  view.antialiased(),
                                  std::min(view.settings.sh_degree, parameters.sh_degree)};
  const VisibleSlots& visible = frame.visible;
  if (field != nullptr) scratch.d_colors.assign(parameters.size(), glm::vec<3, Real>(0));
  for_chunks(visible.chunk_counts.size(), 1, [&](std::size_t chunk) {
    for (std::uint32_t k = 0; k < visible.chunk_counts[chunk]; ++k) {
      const std::size_t slot = chunk * VisibleSlots::kChunk + k;
      PixelSums<Real> sums;
      glm::vec<2, Real> absolute(0);
      for (std::uint64_t at = scratch.begin[slot]; at < scratch.begin[slot + 1]; ++at) {
        sums += scratch.pairs[scratch.order[at]];
        if (order.absolute) absolute += scratch.absolute[scratch.order[at]];
      }
      if (order.absolute) gradients.absolute_px[visible.gaussians[slot]] = absolute;
      SplatGradient<Real> splat = splat_gradient<Real>(frame.splats[slot], sums);
      if (field != nullptr) {
        scratch.d_colors[visible.gaussians[slot]] = splat.color;
        splat.color = glm::vec<3, Real>(0);
      }
      set_gradient(rules, parameters, visible.gaussians[slot], splat, gradients);
    }
  });
  if (field == nullptr) return;
  gradients.by_field.grid.reset(field->grid_values());
  gradients.by_field.weights.assign(field->weights(), 0);
  add_field_gradients(*field, parameters, rules.view.position, scratch.d_colors, view.pool,
                      gradients);
}

template void backward(const StepView&, const Parameters<float>&, const ForwardFrame<float>&,
                       std::span<const glm::vec3>, BackwardScratch<float>&, Gradients<float>&,
                       const BackwardOrder&, const FieldGradient<float>*);
template void backward(const StepView&, const Parameters<double>&, const ForwardFrame<double>&,
                       std::span<const glm::dvec3>, BackwardScratch<double>&, Gradients<double>&,
                       const BackwardOrder&, const FieldGradient<double>*);

}  // namespace qs::cpu::train
