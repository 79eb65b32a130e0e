// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace qs {

/// An array of any number of dimensions.
struct Tensor {
  std::vector<std::uint64_t> shape;  ///< the last index varies fastest
  std::vector<float> values;
};

}  // namespace qs
