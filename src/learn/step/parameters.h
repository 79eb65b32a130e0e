// SPDX-License-Identifier: MIT
//
// The values of a scene that training changes. Real is float, or double to check gradients.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "learn/gradient/mask.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::train {

template <class Real>
struct ParametersOf {
  std::vector<glm::vec<3, Real>> means;       ///< world units
  std::vector<glm::vec<3, Real>> log_scales;  ///< ln of the standard deviations
  /// Quaternions of any length above 0, normalised when used.
  std::vector<glm::qua<Real>> rotations;
  std::vector<Real> opacity_logits;
  std::vector<glm::vec<3, Real>> sh;  ///< sh_stride() RGB triples per Gaussian, DC first
  std::vector<Real> mask_logits;      ///< see kernel/gradient/mask.h; empty without masks
  int sh_degree = kMaxShDegree;
  bool has_masks = false;

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
    mask_logits.resize(has_masks ? count : 0);
  }
  /// Makes room for the arrays that `other` has.
  template <class Other>
  void resize_like(const ParametersOf<Other>& other) {
    sh_degree = other.sh_degree;
    has_masks = other.has_masks;
    resize(other.size());
  }

  bool is_masked_out(std::size_t i) const { return has_masks && masked_out(mask_logits[i]); }
};

using Parameters = ParametersOf<float>;

/// Calls visit(values per Gaussian, array of each of `p`...) for every kind of parameter.
template <class Visit, class First, class... P>
void for_each_array(const Visit& visit, First& first, P&... p) {
  const std::size_t stride = first.sh_stride();
  visit(std::size_t{1}, first.means, p.means...);
  visit(std::size_t{1}, first.log_scales, p.log_scales...);
  visit(std::size_t{1}, first.rotations, p.rotations...);
  visit(std::size_t{1}, first.opacity_logits, p.opacity_logits...);
  visit(stride, first.sh, p.sh...);
  visit(std::size_t{first.has_masks ? 1u : 0u}, first.mask_logits, p.mask_logits...);
}

/// The number of Gaussians that are not masked out.
std::size_t count_existing(const Parameters& parameters);

/// The scene as renderers and files have it: rotations are normalised, and Gaussians that are
/// masked out are left out.
GaussianCloud to_cloud(const Parameters& parameters, bool antialiased);

/// The inverse, up to the length of rotations.
Parameters from_cloud(const GaussianCloud& cloud);

}  // namespace qs::train
