// SPDX-License-Identifier: MIT
//
// The values of a scene that training changes, and the loss's gradient by them. Real is float, or
// double to check gradients.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/gaussian_cloud.h"

namespace qs::cpu::train {

template <class Real>
struct Parameters {
  std::vector<glm::vec<3, Real>> means;       ///< world units
  std::vector<glm::vec<3, Real>> log_scales;  ///< ln of the standard deviations
  std::vector<glm::qua<Real>> rotations;      ///< of any length above 0, normalised when used
  std::vector<Real> opacity_logits;
  std::vector<glm::vec<3, Real>> sh;  ///< sh_stride() RGB triples per Gaussian, DC first
  int sh_degree = kMaxShDegree;

  std::size_t size() const { return means.size(); }
  std::size_t sh_stride() const {
    return static_cast<std::size_t>(sh_coefficient_count(sh_degree));
  }

  /// New values are 0.
  void resize(std::size_t count) {
    means.resize(count);
    log_scales.resize(count);
    rotations.resize(count, glm::qua<Real>(0, 0, 0, 0));
    opacity_logits.resize(count);
    sh.resize(count * sh_stride());
  }
};

/// Calls visit(values per Gaussian, array of each of `p`...) for every kind of parameter.
template <class Visit, class First, class... P>
void for_each_array(const Visit& visit, First& first, P&... p) {
  const std::size_t stride = first.sh_stride();
  visit(std::size_t{1}, first.means, p.means...);
  visit(std::size_t{1}, first.log_scales, p.log_scales...);
  visit(std::size_t{1}, first.rotations, p.rotations...);
  visit(std::size_t{1}, first.opacity_logits, p.opacity_logits...);
  visit(stride, first.sh, p.sh...);
}

/// The same arrays hold derivatives.
template <class Real>
struct Gradients {
  Parameters<Real> by;
  std::vector<glm::vec<2, Real>> mean_px;  ///< by the means on the image
  /// 1 for Gaussians in the view: their square of 3 standard deviations, which the published code
  /// lists, meets the image. It does not depend on the culling mode.
  std::vector<std::uint8_t> visible;

  /// Sets all derivatives to 0 for Gaussians like those of `parameters`.
  void reset(const Parameters<Real>& parameters) {
    by.sh_degree = parameters.sh_degree;
    by.resize(parameters.size());
    for_each_array(
        [](std::size_t, auto& array) {
          std::fill(array.begin(), array.end(),
                    typename std::decay_t<decltype(array)>::value_type{});
        },
        by);
    mean_px.assign(parameters.size(), glm::vec<2, Real>(0));
  }
};

/// The scene as renderers and files have it: rotations are normalised.
GaussianCloud to_cloud(const Parameters<float>& parameters, bool antialiased);

/// The inverse, up to the length of rotations.
Parameters<float> from_cloud(const GaussianCloud& cloud);

}  // namespace qs::cpu::train
