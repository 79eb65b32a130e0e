// SPDX-License-Identifier: MIT
//
// The forward pass of training: both passes of the differentiable rasterizer, for the parameters of
// a model in training.
#pragma once

#include <algorithm>
#include <stop_token>
#include <vector>

#include "learn/diff/cpu/blend.h"
#include "learn/gradient/gaussian.h"
#include "learn/step/cpu/parameters.h"

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

}  // namespace qs::cpu::train
