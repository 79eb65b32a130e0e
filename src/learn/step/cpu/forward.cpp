// SPDX-License-Identifier: MIT
#include <glm/geometric.hpp>

#include "learn/diff/cpu/blend.h"
#include "learn/diff/cpu/project_gaussians.h"
#include "learn/gradient/gaussian.h"
#include "learn/step/cpu/field_pass.h"
#include "learn/step/cpu/passes.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/sh.h"

namespace qs::cpu::train {
namespace {

/// The Gaussians of a model, as a source of project_gaussians().
template <class Real>
struct TrainedGaussians {
  static constexpr bool kReports = false;

  const Parameters<Real>& parameters;
  const FieldGradient<Real>* field;
  glm::vec<3, Real> eye;
  int degree;
  std::size_t stride = parameters.sh_stride();

  bool exists(std::size_t i) const { return !parameters.is_masked_out(i); }
  const glm::vec<3, Real>& mean(std::size_t i) const { return parameters.means[i]; }
  Covariance3<double> covariance(std::size_t i) const {
    return covariance_of(glm::dvec3(parameters.log_scales[i]),
                         unit_rotation(glm::dquat(parameters.rotations[i])));
  }
  double opacity(std::size_t i) const {
    return opacity_of(static_cast<double>(parameters.opacity_logits[i]));
  }
  glm::vec<3, Real> color(std::size_t i, const glm::vec<3, Real>& mean) const {
    if (field != nullptr) return field_color(*field, mean, eye);
    const glm::vec<3, Real>* sh = &parameters.sh[i * stride];
    return sh_color<Real>(degree, glm::normalize(mean - eye), [sh](int k) { return sh[k]; });
  }
};

}  // namespace

template <class Real>
void forward(const StepView& view, const Parameters<Real>& parameters, ForwardFrame<Real>& frame,
             const FieldGradient<Real>* field) {
  // The stages below read nothing else of a cloud.
  GaussianCloud facts;
  facts.sh_degree = parameters.sh_degree;
  facts.antialiased = view.antialiased();
  const FrameContext context{facts, view.camera, view.settings, view.grid(), view.pool, view.stop};
  const GradientRules<Real> rules = view.rules(parameters);
  const TrainedGaussians<Real> source{parameters, field, rules.view.position, rules.sh_degree};
  diff::project_gaussians<Real>(context, make_view<float>(view.camera), context.rules(), rules,
                                source, parameters.size(), frame);
  diff::list_gaussians(context, frame);
  frame.resize(view.size().pixels());
  const glm::vec<3, Real> background(view.settings.background);
  diff::blend(view.blend_input(background), frame.view(), view.workers(), frame.state());
}

template decltype(forward<float>) forward<float>;
template decltype(forward<double>) forward<double>;

}  // namespace qs::cpu::train
