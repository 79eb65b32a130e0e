// SPDX-License-Identifier: MIT
//
// Weights and pictures made by a rule, so that LPIPS is tested without the published weights. One
// counter k runs over all values: filters and biases of every convolution, then the linear layers.
// With u = frac((k + 1) 0.618...) a filter's value is (2u - 1) sqrt(6 / inputs of the sum), a
// bias 0.1 (2u - 1), a linear weight u, and a pixel floor(256 u) / 255.
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "learn/lpips/lpips.h"

namespace qs::test {

/// frac((k + 1) (sqrt(5) - 1) / 2), in double precision.
inline double golden_fraction(std::size_t k) {
  const double value = (static_cast<double>(k) + 1.0) * 0.6180339887498949;
  return value - std::floor(value);
}

inline lpips::Weights golden_weights(const lpips::Network& network) {
  lpips::Weights weights;
  weights.network = &network;
  std::size_t k = 0;
  const auto fill = [&k](std::size_t count, auto value) {
    std::vector<float> values(count);
    for (float& one : values) one = static_cast<float>(value(golden_fraction(k++)));
    return values;
  };
  for (const lpips::Convolution& layer : network.convolutions) {
    const auto inputs = static_cast<std::size_t>(layer.inputs * layer.size * layer.size);
    const auto outputs = static_cast<std::size_t>(layer.outputs);
    const double bound = std::sqrt(6.0 / static_cast<double>(inputs));
    weights.filters.push_back(
        fill(outputs * inputs, [&](double u) { return (2 * u - 1) * bound; }));
    weights.biases.push_back(fill(outputs, [](double u) { return 0.1 * (2 * u - 1); }));
  }
  for (const lpips::Convolution& layer : network.convolutions) {
    if (!layer.compared) continue;
    weights.linear.push_back(
        fill(static_cast<std::size_t>(layer.outputs), [](double u) { return u; }));
  }
  return weights;
}

/// A picture, and the same picture moved right by a pixel, the last column in front. The rule fills
/// the picture plane by plane.
inline std::pair<Image, Image> golden_pictures(int width, int height) {
  Image picture(width, height, 3), moved(width, height, 3);
  std::size_t k = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto value = static_cast<float>(std::floor(256 * golden_fraction(k++)) / 255);
        picture.at(x, y, c) = value;
        moved.at((x + 1) % width, y, c) = value;
      }
    }
  }
  return {picture, moved};
}

}  // namespace qs::test
