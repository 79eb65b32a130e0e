// SPDX-License-Identifier: MIT
//
// The passes of training over the parameters of a model. The forward pass joins both passes of the
// differentiable rasterizer. The backward pass goes from the loss's derivatives by the pixels to
// its derivatives by all parameters, and joins the backward passes of both, so that no boundary is
// stored between them. The results do not depend on the number of threads, see
// learn/diff/cpu/blend.h.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "base/parallel.h"
#include "learn/diff/cpu/blend.h"
#include "learn/gradient/adam.h"
#include "learn/gradient/gaussian.h"
#include "learn/step/cpu/parameters.h"
#include "learn/step/model_state.h"
#include "learn/step/plan.h"

namespace qs::cpu::train {

/// The view of one training step.
struct StepView {
  const Camera& camera;
  /// mode, sh_degree, background, antialiased (unset = no) and dilation are used.
  const RenderSettings& settings;
  ThreadPool& pool;
  std::stop_token stop = {};

  diff::PictureSize size() const { return {camera.width, camera.height}; }
  TileGrid grid() const { return size().grid(); }
  diff::Workers workers() const { return {pool, stop}; }
  bool antialiased() const { return settings.antialiased.value_or(false); }

  template <class Real>
  GradientRules<Real> rules(const Parameters<Real>& parameters) const {
    return {make_view<Real>(camera), settings.dilation, antialiased(),
            std::min(settings.sh_degree, parameters.sh_degree)};
  }
  /// `background` is the settings', and outlives the result.
  template <class Real>
  diff::BlendInput<Real> blend_input(const glm::vec<3, Real>& background) const {
    return {size(), {}, 3, {}, &background[0]};
  }
};

template <class Real>
struct ForwardFrame : diff::ProjectedFrame<Real> {
  // Per pixel, row by row.
  std::vector<glm::vec<3, Real>> color;  ///< over the background, not clamped
  std::vector<Real> transmittance;       ///< behind the last Gaussian
  std::vector<std::uint32_t> last;  ///< entries of the tile's list up to the last blended entry

  void resize(std::size_t pixels) {
    color.resize(pixels);
    transmittance.resize(pixels);
    last.resize(pixels);
  }
  diff::PixelState<Real> state() {
    return {&color[0][0], transmittance.data(), last.data(), nullptr, nullptr};
  }
  diff::PixelState<const Real> state() const {
    return {&color[0][0], transmittance.data(), last.data(), nullptr, nullptr};
  }
};

/// Throws Cancelled, and Error(device) if the tile lists do not fit into memory.
/// `field`: the colours, in place of coefficients; may be null.
template <class Real>
void forward(const StepView& view, const Parameters<Real>& parameters, ForwardFrame<Real>& frame,
             const FieldGradient<Real>* field = nullptr);

/// Memory of backward() that the next step uses again.
template <class Real>
struct BackwardScratch {
  diff::PairScratch<Real> pairs;
  /// Derivative by Gaussians' colours, with a colour field.
  std::vector<glm::vec<3, Real>> d_colors;
};

/// `frame` is the result of forward() for the same arguments; `d_color` is per pixel, row by row.
/// With a field, the coefficients of colour have no derivatives.
template <class Real>
void backward(const StepView& view, const Parameters<Real>& parameters,
              const ForwardFrame<Real>& frame, std::span<const glm::vec<3, Real>> d_color,
              BackwardScratch<Real>& scratch, Gradients<Real>& gradients,
              const BackwardOrder& order = {}, const FieldGradient<Real>* field = nullptr);

/// Counts the pixels of a view that blend each Gaussian, and the pixels among them with a large
/// error. It walks the lists of the forward pass a second time. The counts are integers, so the
/// order of threads does not matter. Adds the view's pixels to `counts`, which has an element for
/// every Gaussian or is empty. `frame` is the result of forward(); `target` is the photograph per
/// pixel, row by row; `mask` as in LossInput.
void count_errors(const StepView& view, const ForwardFrame<float>& frame,
                  std::span<const glm::vec3> target, std::span<const std::uint8_t> mask,
                  std::size_t gaussians, PixelCounts& counts);

// The end of an iteration: the optimizer, which is Adam for all parameters, with a learning rate
// for each kind, and the statistics of adaptive density control.

/// One step. All arguments have the same Gaussians. `moves_rest`: also of the coefficients of
/// colour beyond DC.
void take_step(Parameters<float>& parameters, const Parameters<float>& gradient, const Rates& rates,
               AdamState& state, ThreadPool& pool, bool moves_rest = true);

/// Adds `gradient` to `sums`, which may be empty.
void add_gradients(const Parameters<float>& gradient, ThreadPool& pool, Parameters<float>& sums);

/// Sets the sums that a step has used to 0. If that is all of them, `sums` becomes empty.
void clear_sums(bool rest_too, Parameters<float>& sums);

/// Adds a view of `width` x `height` pixels, with absolute gradients if `gradients` has them.
/// `counted` is 1 for the Gaussians that it counts for.
void add_view(const Gradients<float>& gradients, std::span<const std::uint8_t> counted, int width,
              int height, DensityStatistics& statistics);

}  // namespace qs::cpu::train
