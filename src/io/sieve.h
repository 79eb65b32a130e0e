// SPDX-License-Identifier: MIT
//
// The last step of every reader: rotations become unit quaternions, Gaussians that no renderer
// could draw (NaN, infinite or absurd values) are taken out, and the scene says in whole sentences
// what was dropped or looks wrong. After finish() the promises on GaussianCloud's members hold.
#pragma once

#include <array>
#include <cstddef>
#include <mutex>
#include <vector>

#include "io/reader.h"

namespace qs {

class Sieve {
 public:
  explicit Sieve(GaussianCloud& cloud) : cloud_(cloud) {}

  /// Looks at the Gaussians [begin, end) right after they were filled, while they are in the cache.
  /// May be called from several threads for disjoint ranges.
  void inspect(std::size_t begin, std::size_t end);

  /// Removes what inspect() found and adds the warnings to `scene`, which owns the cloud. Throws
  /// Error(input) when no Gaussian is left.
  void finish(Scene& scene);

 private:
  enum Flaw { position, scale, rotation, opacity, color, kFlaws };
  struct Dropped {
    std::size_t index;
    Flaw flaw;
  };

  bool normalise_rotations(std::size_t begin, std::size_t end);
  void find_flaws(std::size_t begin, std::size_t end, std::vector<Dropped>& found) const;
  void remove_dropped();

  GaussianCloud& cloud_;
  std::mutex mutex_;
  std::vector<Dropped> dropped_;  // in any order of chunks
  bool all_scales_positive_ = true;
  bool all_transparent_ = true;
};

}  // namespace qs
