// SPDX-License-Identifier: MIT
//
// Residual vector quantisation (Zeghidour et al., SoundStream, 2021): a vector is the sum of one
// code of every stage, where each stage approximates what the stages before leave.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace qs {

struct ResidualCodebook {
  std::size_t stages = 6;
  int bits = 6;                ///< bits of the number of a code; 1..16
  std::size_t dimensions = 3;  ///< dimensions of a vector
  std::vector<float> values;   ///< (stages, 2^bits, dimensions)

  std::size_t codes() const { return std::size_t{1} << bits; }
  std::size_t value_count() const { return stages * codes() * dimensions; }

  const float* code(std::size_t stage, std::size_t number) const {
    return &values[(stage * codes() + number) * dimensions];
  }

  /// The vector of `numbers`, a code of each stage, each below codes().
  void decode(std::span<const std::uint16_t> numbers, float* vector) const {
    assert(numbers.size() == stages);
    for (std::size_t k = 0; k < dimensions; ++k) vector[k] = 0;
    for (std::size_t stage = 0; stage < stages; ++stage) {
      const float* const part = code(stage, numbers[stage]);
      for (std::size_t k = 0; k < dimensions; ++k) vector[k] += part[k];
    }
  }

  /// The nearest code of each stage for `vector`; of equally near codes the first.
  void encode(const float* vector, std::span<std::uint16_t> numbers) const;
};

}  // namespace qs
