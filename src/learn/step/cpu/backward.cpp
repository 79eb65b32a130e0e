// SPDX-License-Identifier: MIT
#include "learn/gradient/gaussian.h"
#include "learn/step/cpu/field_pass.h"
#include "learn/step/cpu/passes.h"

namespace qs::cpu::train {
namespace {

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
  const glm::vec<3, Real> background(view.settings.background);
  const diff::FrameView<Real> drawn = frame.view();
  const auto pixels = diff::Pixels<const Real>::packed(&d_color[0][0], view.camera.width, 3);
  diff::sum_pairs<3>(view.blend_input(background), drawn, frame.state(), {pixels, {}, {}, {}},
                     order.absolute, view.workers(), scratch.pairs);

  gradients.reset(parameters);
  gradients.absolute_px.assign(order.absolute ? parameters.size() : 0, glm::vec<2, Real>(0));
  gradients.visible = frame.in_view;
  const GradientRules<Real> rules = view.rules(parameters);
  if (field != nullptr) scratch.d_colors.assign(parameters.size(), glm::vec<3, Real>(0));
  view.workers().for_each(drawn.counts.size(), 1, [&](std::size_t chunk) {
    drawn.for_chunk(chunk, [&](std::size_t slot) {
      const std::uint32_t i = drawn.gaussians[slot];
      auto gradient = diff::SlotGradient<Real, 3>::of(drawn, slot, scratch.pairs);
      if (order.absolute) gradients.absolute_px[i] = gradient.absolute;
      if (field != nullptr) {
        scratch.d_colors[i] = gradient.splat.color;
        gradient.splat.color = glm::vec<3, Real>(0);
      }
      set_gradient(rules, parameters, i, gradient.splat, gradients);
    });
  });
  if (field == nullptr) return;
  gradients.by_field.grid.reset(field->grid_values());
  gradients.by_field.weights.assign(field->weights(), 0);
  add_field_gradients(*field, parameters, rules.view.position, scratch.d_colors, view.pool,
                      gradients);
}

template decltype(backward<float>) backward<float>;
template decltype(backward<double>) backward<double>;

}  // namespace qs::cpu::train
