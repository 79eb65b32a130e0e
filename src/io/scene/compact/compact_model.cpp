// SPDX-License-Identifier: MIT
#include "io/scene/compact/compact_model.h"

#include <utility>

#include "base/fail.h"

namespace qs {
namespace {

// Option --max_hashmap of Compact-3DGS, 19 by default.
constexpr int kLeastLog2Entries = 3, kMostLog2Entries = 21;

}  // namespace

ColorField make_color_field(std::vector<float> grid_values, std::vector<float> weights,
                            const std::string& source) {
  ColorField field;
  const std::size_t expected = field.network().weight_count();
  if (weights.size() != expected) {
    fail("{}: its network has {} weights, but networks of Compact-3DGS have {}", source,
         weights.size(), expected);
  }
  for (int log2 = kLeastLog2Entries; log2 <= kMostLog2Entries; ++log2) {
    field.grid.log2_entries = log2;
    if (grid_value_count(field.grid) != grid_values.size()) continue;
    field.grid_values = std::move(grid_values);
    field.weights = std::move(weights);
    return field;
  }
  fail("{}: its hash grid has {} values, which fit no grid of Compact-3DGS", source,
       grid_values.size());
}

}  // namespace qs
