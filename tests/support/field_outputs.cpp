// SPDX-License-Identifier: MIT
#include "support/field_outputs.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "raster/kernel/color_field.h"

namespace qs::test {
namespace {

// Products of a matrix with `rows` rows and a vector.
std::vector<double> multiplied(const float* matrix, std::size_t rows, const std::vector<double>& x,
                               bool relu) {
  std::vector<double> y(rows);
  for (std::size_t row = 0; row < rows; ++row, matrix += x.size()) {
    double sum = 0;
    for (std::size_t k = 0; k < x.size(); ++k) sum += static_cast<double>(matrix[k]) * x[k];
    y[row] = relu ? std::max(sum, 0.0) : sum;
  }
  return y;
}

}  // namespace

std::vector<double> grid_features(const ColorField& field, const glm::dvec3& mean) {
  const glm::dvec3 position = contract(mean);
  std::vector<double> features;
  for (const GridLevel& level : grid_levels(field.grid)) {
    std::array<double, kGridFeatures> sums{};
    for_each_vertex(level, position, [&](std::size_t entry, double weight) {
      for (std::size_t k = 0; k < sums.size(); ++k)
        sums[k] += weight * static_cast<double>(field.grid_values[entry * kGridFeatures + k]);
    });
    features.insert(features.end(), sums.begin(), sums.end());
  }
  return features;
}

glm::dvec3 network_output(const ColorField& field, const std::vector<double>& features,
                          const glm::dvec3& direction) {
  const NetworkShape shape = field.network();
  std::vector<double> x(static_cast<std::size_t>(shape.inputs()), 1.0);
  std::ranges::copy(features, x.begin());
  encode_direction(direction, x.data() + features.size());
  const auto width = static_cast<std::size_t>(shape.width);
  const float* const weights = field.weights.data();
  x = multiplied(weights, width, x, true);
  x = multiplied(weights + shape.second(), width, x, true);
  x = multiplied(weights + shape.third(), 3, x, false);
  return {x[0], x[1], x[2]};
}

}  // namespace qs::test
