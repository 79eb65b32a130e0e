// SPDX-License-Identifier: MIT
#include "raster/field/residual_codebook.h"

#include "raster/kernel/nearest_code.h"

namespace qs {

std::uint16_t ResidualCodebook::nearest(std::size_t layer, const float* vector) const {
  return static_cast<std::uint16_t>(nearest_code(code(layer, 0), static_cast<unsigned>(codes()),
                                                 static_cast<unsigned>(dimensions), vector));
}

void ResidualCodebook::encode(const float* vector, std::span<std::uint16_t> numbers) const {
  assert(numbers.size() == layers);
  std::vector<float> rest(vector, vector + dimensions);
  for (std::size_t layer = 0; layer < layers; ++layer) {
    numbers[layer] = nearest(layer, rest.data());
    const float* const chosen = code(layer, numbers[layer]);
    for (std::size_t k = 0; k < dimensions; ++k) rest[k] -= chosen[k];
  }
}

}  // namespace qs
