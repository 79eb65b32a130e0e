// SPDX-License-Identifier: MIT
#include "raster/field/residual_codebook.h"

#include <limits>

namespace qs {

void ResidualCodebook::encode(const float* vector, std::span<std::uint16_t> numbers) const {
  assert(numbers.size() == stages);
  std::vector<float> rest(vector, vector + dimensions);
  for (std::size_t stage = 0; stage < stages; ++stage) {
    float nearest = std::numeric_limits<float>::infinity();
    numbers[stage] = 0;
    for (std::size_t number = 0; number < codes(); ++number) {
      const float* const candidate = code(stage, number);
      float distance = 0;
      for (std::size_t k = 0; k < dimensions; ++k)
        distance += (rest[k] - candidate[k]) * (rest[k] - candidate[k]);
      if (distance < nearest) {
        nearest = distance;
        numbers[stage] = static_cast<std::uint16_t>(number);
      }
    }
    const float* const chosen = code(stage, numbers[stage]);
    for (std::size_t k = 0; k < dimensions; ++k) rest[k] -= chosen[k];
  }
}

}  // namespace qs
