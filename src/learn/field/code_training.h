// SPDX-License-Identifier: MIT
//
// Residual codebooks: their fit to vectors, layer by layer, and codes that are trained together
// with the vectors that they stand for (Compact-3DGS, Lee et al., CVPR 2024): the codes follow the
// vectors, and the gradient by a coded vector counts as the gradient by the vector (straight
// through).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "raster/field/residual_codebook.h"
#include "raster/kernel/random.h"

namespace qs {

/// A codebook of `shape` (its values are not read) for vectors of shape.dimensions finite values
/// each. The codes of a layer begin at vectors that `random` chooses among the remainders of the
/// layers before, and move `rounds` times to the mean of the vectors that are nearest to them
/// (k-means). The result does not depend on the number of threads. Without vectors all codes are 0.
ResidualCodebook fit_codebook(ResidualCodebook shape, std::span<const float> vectors,
                              const Random& random, ThreadPool& pool, int rounds = 10);

/// The codes of all vectors, one of each layer, vector by vector.
std::vector<std::uint16_t> encode_all(const ResidualCodebook& codebook,
                                      std::span<const float> vectors, ThreadPool& pool);

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
