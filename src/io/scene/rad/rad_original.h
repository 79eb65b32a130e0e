// SPDX-License-Identifier: MIT
//
// The values of leaves before they were rounded, which `quadsplat lod --original` keeps in the
// block of rad_writer.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/scene/rad/rad_chunk.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Words of a leaf: its number in the order of the sources, then the bits of its logit, log scales,
/// rotation w x y z and SH, which are RGB triples, degree 0 first.
constexpr std::size_t original_words(int sh_degree) {
  return 9 + 3 * static_cast<std::size_t>(sh_coefficient_count(sh_degree));
}

/// Stores Gaussian `i` in the words of a leaf. SH that the cloud lacks are 0.
void pack_original(const GaussianCloud& cloud, std::size_t i, std::uint32_t number,
                   std::span<std::uint32_t> words);

class RadOriginals {
 public:
  /// Empty if the chunk has none. Throws Error(input) if they are damaged.
  explicit RadOriginals(const RadChunk& chunk);

  bool empty() const { return leaf_of_.empty(); }

  /// By row: the number of a leaf; kNoNumber for a merged node. Empty if this is.
  std::vector<std::uint32_t> numbers() const;

  /// Sets Gaussians `places[i]` of a cloud, which has at least the SH of the chunk, to the values
  /// of the leaves among `rows`.
  void restore(std::span<const std::uint32_t> rows, std::span<const std::uint32_t> places,
               GaussianCloud& cloud) const;

 private:
  std::size_t words_, leaves_ = 0;
  std::vector<std::uint32_t> leaf_of_;  // by row; ~0: a merged node
  std::vector<std::uint32_t> values_;   // the first words of all leaves, then the second ones ...
};

}  // namespace qs
