// SPDX-License-Identifier: MIT
//
// Everything that training changes, in the host's memory. A checkpoint holds exactly this, and
// every backend can continue from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "learn/field/code_training.h"
#include "learn/gradient/mask.h"
#include "raster/field/color_field.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::train {

/// The values of a scene that training changes. Real is float, or double to check gradients.
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

/// Adam's moments, one per value of the parameters, and the number of steps so far.
struct AdamState {
  Parameters first, second;
  std::uint64_t steps = 0;
  std::uint64_t rest_steps = 0;  ///< steps of the coefficients of colour beyond DC

  /// Zero moments for the Gaussians of `parameters`.
  static AdamState like(const Parameters& parameters);
};

/// The statistics of adaptive density control: the length of the loss's gradient by a Gaussian's
/// position on the image, as the mean over the views that showed the Gaussian.
struct DensityStatistics {
  /// Per Gaussian: sum of |dL/d mean| in normalised device coordinates, where the image is 2 wide
  /// and 2 high, and the number of views in it.
  std::vector<float> sums;
  std::vector<std::uint32_t> views;
  /// The sums of absolute gradients, else as `sums`, see BackwardOrder. Empty unless a view was
  /// counted with them.
  std::vector<float> absolute;

  void reset(std::size_t gaussians);
  /// 0 for a Gaussian that no view showed.
  float mean(std::size_t i) const;
  float mean_absolute(std::size_t i) const;
};

/// Numbers of Gaussians that a strategy with a limited growth remembers; 0 before its first change.
struct GrowthState {
  std::uint64_t initial = 0;  ///< at the start
  std::uint64_t budget = 0;   ///< that may be added at full size
};

/// A colour field in training, whose colours replace the coefficients of colour. A model without
/// one has no values here.
struct FieldState {
  ColorField field;
  std::vector<float> first, second;  ///< Adam's moments: of the grid, then of the weights
  std::uint64_t steps = 0;

  /// Zero moments.
  static FieldState starting_with(ColorField field);

  bool exists() const { return !field.weights.empty(); }
};

/// Codes of scales and normalised rotations in training. A model without codes has no values here.
struct ShapeCodes {
  CodeState scales, rotations;

  bool exist() const { return scales.exists(); }
};

struct ModelState {
  int iteration = 0;       ///< iteration of the last step; 0: none was taken
  int changed_before = 0;  ///< the set of Gaussians last changed before this iteration
  Parameters parameters;
  AdamState adam;
  Parameters
      summed;  ///< gradients since the last step, see StepOrder::sums; empty if there are none
  DensityStatistics density;
  GrowthState growth;
  FieldState color_field;
  ShapeCodes codes;  ///< all passes use the coded shapes

  static ModelState starting_with(Parameters parameters);

  std::size_t size() const { return parameters.size(); }
};

/// The derivatives that a backward pass computes beside the parameters'.
struct BackwardOrder {
  /// Also sums the absolute values of each pixel's derivatives by a Gaussian's position on the
  /// image (AbsGS, Ye et al. 2024, arXiv 2404.10484). Parts of opposite signs do not cancel in
  /// these sums, so they show large Gaussians whose pixels want to move apart.
  bool absolute = false;
};

}  // namespace qs::train
