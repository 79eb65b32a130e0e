// SPDX-License-Identifier: MIT
//
// Everything that training changes, in the host's memory. A checkpoint holds exactly this, and
// every backend can continue from it.
#pragma once

#include <cstdint>
#include <vector>

#include "learn/field/code_training.h"
#include "learn/step/parameters.h"
#include "raster/field/color_field.h"

namespace qs::train {

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

}  // namespace qs::train
