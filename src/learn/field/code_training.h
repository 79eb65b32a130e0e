// SPDX-License-Identifier: MIT
//
// Residual codes that are trained together with the vectors that they stand for (Compact-3DGS, Lee
// et al., CVPR 2024): the codes follow the vectors, and the gradient by a coded vector counts as
// the gradient by the vector (straight through).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "raster/field/residual_codebook.h"

namespace qs {

/// A codebook in training.
struct CodeState {
  ResidualCodebook codebook;
  std::vector<float> first, second;  ///< Adam's moments of its values
  std::uint64_t steps = 0;

  static CodeState starting_with(ResidualCodebook codebook);

  bool exists() const { return !codebook.values.empty(); }
};

/// The vectors as their codes give them.
std::vector<float> coded(const ResidualCodebook& codebook, std::span<const float> vectors,
                         ThreadPool& pool);

/// One step of Adam (rate 1e-4, epsilon 1e-8) of every layer's codes, for the mean squared
/// difference to the remainders of the layers before. The result does not depend on the number of
/// threads.
void take_code_step(CodeState& state, std::span<const float> vectors, ThreadPool& pool);

}  // namespace qs
