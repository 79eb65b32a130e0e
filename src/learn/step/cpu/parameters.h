// SPDX-License-Identifier: MIT
//
// The loss's gradient by the parameters of a scene.
#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <vector>

#include <glm/vec2.hpp>

#include "learn/field/field_gradient.h"
#include "learn/step/model_state.h"

namespace qs::cpu::train {

using namespace qs::train;

template <class Real>
using Parameters = qs::train::ParametersOf<Real>;

/// Derivatives by a colour field.
template <class Real>
struct FieldGradients {
  IntegerSums grid;
  std::vector<Real> weights;
  std::vector<Real> block_weights;  ///< memory that the next step uses again
};

/// The same arrays hold derivatives.
template <class Real>
struct Gradients {
  Parameters<Real> by;
  std::vector<glm::vec<2, Real>> mean_px;  ///< derivative by the means on the image
  /// Per Gaussian: the sums over pixels of the absolute values of the pixels' parts of mean_px.
  /// Empty if backward() was not asked for them.
  std::vector<glm::vec<2, Real>> absolute_px;
  /// 1 for Gaussians in the view, see is_in_view() of kernel/cull/in_view.h.
  std::vector<std::uint8_t> visible;
  FieldGradients<Real> by_field;  ///< if the model has a colour field

  /// Sets all derivatives to 0, for the number of Gaussians and the SH degree of `parameters`.
  void reset(const Parameters<Real>& parameters) {
    by.resize_like(parameters);
    for_each_array(
        [](std::size_t, auto& array) {
          std::ranges::fill(array, typename std::decay_t<decltype(array)>::value_type{});
        },
        by);
    mean_px.assign(parameters.size(), glm::vec<2, Real>(0));
  }
};

}  // namespace qs::cpu::train
