// SPDX-License-Identifier: MIT
//
// The edits of a scene: what was done to its Gaussians after its file was read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include <glm/vec2.hpp>

#include "raster/scene/gaussian_set.h"

namespace qs {

/// "crc32:89abcdef" of the set's bytes.
std::string set_hash(const GaussianSet& set);

/// Edits as reports name them.
struct EditFacts {
  int steps = 0;           ///< steps that removed or hid Gaussians
  std::uint64_t kept = 0;  ///< Gaussians of the file that are left
  std::uint64_t of = 0;    ///< Gaussians of the file as it was read; 0: unknown, of a tree's pages
  std::string
      crc;  ///< "crc32:89abcdef" of Edits::removed, or of the edits' file; empty without steps
  glm::ivec2 copies{1, 1};  ///< the rest is repeated on a grid

  bool operator==(const EditFacts&) const = default;
};

struct Edits : EditFacts {
  /// By the index in the file as it was read; empty without steps. Equal rests have equal hashes,
  /// independent of the steps.
  GaussianSet removed;

  /// One step: removes Gaussian i of the `count` that are left if goes(i).
  void remove(std::size_t count, const std::function<bool(std::size_t i)>& goes);
  /// So many steps: these Gaussians of the file are gone now.
  void remove(int count_of_steps, const GaussianSet& gone);

  /// The facts after so many more steps, by which these of the Gaussians that are left are gone.
  EditFacts with(const GaussianSet& gone, int count_of_steps) const;
};

}  // namespace qs
