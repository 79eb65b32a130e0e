// SPDX-License-Identifier: MIT
#include "raster/field/field_evaluator.h"

#include <array>
#include <cmath>
#include <cstddef>

#include <glm/gtc/constants.hpp>

#include "raster/kernel/half.h"
#include "raster/kernel/sh.h"

namespace qs {
namespace {

using field_vectors::kRows;

float rounded(float value) { return float_of_any_half(round_to_half(value)); }

// Columns [begin, end) of the first `rows` rows of a matrix, in blocks of kBlock rows; missing rows
// are 0.
template <std::size_t kBlock>
std::vector<float> blocks(const float* matrix, std::size_t rows, std::size_t columns,
                          std::size_t begin, std::size_t end) {
  std::vector<float> packed;
  for (std::size_t row = 0; row < rows; row += kBlock)
    for (std::size_t column = begin; column < end; ++column)
      for (std::size_t i = row; i < row + kBlock; ++i)
        packed.push_back(i < rows ? rounded(matrix[i * columns + column]) : 0.0f);
  return packed;
}

// The squares of the components are the roots of z^3 - z^2 + z/5 - 1/105, by the cosine formula for
// three real roots, in ascending order.
glm::dvec3 first_direction() {
  const double p = -2.0 / 15, q = -2.0 / 27 + 1.0 / 15 - 1.0 / 105;
  const double angle = std::acos(1.5 * q / p * std::sqrt(-3 / p)) / 3;
  const auto root = [&](int k) {
    return 1.0 / 3 + 2 * std::sqrt(-p / 3) * std::cos(angle - k * 2 * glm::pi<double>() / 3);
  };
  return {std::sqrt(root(2)), std::sqrt(root(1)), std::sqrt(root(0))};
}

}  // namespace

std::array<glm::dvec3, kDesignSize> design_directions() {
  // A rotation of the cube permutes axes and turns some over: an even number if the permutation is
  // even, else an odd number.
  struct Permutation {
    std::array<int, 3> axes;
    bool odd;
  };
  constexpr std::array<Permutation, 6> kPermutations = {{{{0, 1, 2}, false},
                                                         {{1, 2, 0}, false},
                                                         {{2, 0, 1}, false},
                                                         {{0, 2, 1}, true},
                                                         {{2, 1, 0}, true},
                                                         {{1, 0, 2}, true}}};
  const glm::dvec3 first = first_direction();
  std::array<glm::dvec3, kDesignSize> directions;
  std::size_t next = 0;
  for (const Permutation& permutation : kPermutations) {
    for (int turned = 0; turned < 8; ++turned) {
      const bool odd = ((turned ^ turned >> 1 ^ turned >> 2) & 1) != 0;
      if (odd != permutation.odd) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const double value = first[permutation.axes[static_cast<std::size_t>(axis)]];
        directions[next][axis] = (turned >> axis & 1) != 0 ? -value : value;
      }
      ++next;
    }
  }
  return directions;
}

ShDesign sh_design() {
  ShDesign design;
  const auto directions = design_directions();
  for (std::size_t j = 0; j < directions.size(); ++j) {
    std::array<double, 16> basis;
    sh_basis(directions[j], basis.data());
    for (std::size_t i = 0; i < basis.size(); ++i) {
      design.basis[j][i] = static_cast<float>(basis[i]);
      design.weights[j][i] = static_cast<float>(4 * glm::pi<double>() / kDesignSize * basis[i]);
    }
  }
  return design;
}

FieldEvaluator::FieldEvaluator(const ColorField& field) {
  const NetworkShape shape = field.network();
  const auto width = static_cast<std::size_t>(shape.width);
  const auto inputs = static_cast<std::size_t>(shape.inputs());
  const auto grid_inputs = static_cast<std::size_t>(shape.grid_inputs);
  const std::size_t ones = grid_inputs + kDirectionFeatures;
  const float* const first = field.weights.data();

  packed_.levels = grid_levels(field.grid);
  packed_.entries.resize(field.grid_values.size() / kGridFeatures);
  for (std::size_t i = 0; i < packed_.entries.size(); ++i) {
    const float* const values = &field.grid_values[i * kGridFeatures];
    packed_.entries[i] =
        round_to_half(values[0]) | static_cast<std::uint32_t>(round_to_half(values[1])) << 16;
  }
  packed_.width = width;
  packed_.from_grid = blocks<kRows>(first, width, inputs, 0, grid_inputs);
  packed_.from_direction = blocks<kRows>(first, width, inputs, grid_inputs, ones);
  packed_.hidden = blocks<kRows>(first + shape.second(), width, width, 0, width);
  packed_.last = blocks<field_vectors::kOutRows>(first + shape.third(), 3, width, 0, width);
  packed_.design = sh_design();
  packed_.bias.resize(width);
  for (std::size_t row = 0; row < width; ++row)
    for (std::size_t column = ones; column < inputs; ++column)
      packed_.bias[row] += rounded(first[row * inputs + column]);
  for (const glm::dvec3& direction : design_directions()) {
    std::array<double, kDirectionFeatures> features;
    encode_direction(direction, features.data());
    for (std::size_t row = 0; row < width; ++row) {
      double sum = static_cast<double>(packed_.bias[row]);
      for (std::size_t k = 0; k < features.size(); ++k)
        sum += features[k] * static_cast<double>(rounded(first[row * inputs + grid_inputs + k]));
      packed_.of_design.push_back(static_cast<float>(sum));
    }
  }
}

}  // namespace qs
