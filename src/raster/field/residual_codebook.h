// SPDX-License-Identifier: MIT
//
// Residual vector quantisation (Zeghidour et al., SoundStream, 2021): a vector is the sum of one
// code of every layer, where each layer approximates what the layers before leave.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace qs {

struct ResidualCodebook {
  std::size_t layers = 6;
  int bits = 6;                ///< bits of the number of a code; 1..16
  std::size_t dimensions = 3;  ///< dimensions of a vector
  std::vector<float> values;   ///< (layers, 2^bits, dimensions)

  std::size_t codes() const { return std::size_t{1} << bits; }
  std::size_t value_count() const { return layers * codes() * dimensions; }

  const float* code(std::size_t layer, std::size_t number) const {
    return &values[(layer * codes() + number) * dimensions];
  }

  /// The vector of `numbers`, a code of each layer, each below codes().
  void decode(std::span<const std::uint16_t> numbers, float* vector) const {
    assert(numbers.size() == layers);
    for (std::size_t k = 0; k < dimensions; ++k) vector[k] = 0;
    for (std::size_t layer = 0; layer < layers; ++layer) {
      const float* const part = code(layer, numbers[layer]);
      for (std::size_t k = 0; k < dimensions; ++k) vector[k] += part[k];
    }
  }

  /// The code of a layer that is nearest to `vector`; of equally near codes the first.
  std::uint16_t nearest(std::size_t layer, const float* vector) const;

  /// The nearest code of each layer for what the layers before leave of `vector`.
  void encode(const float* vector, std::span<std::uint16_t> numbers) const;
};

}  // namespace qs
