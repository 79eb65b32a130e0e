// SPDX-License-Identifier: MIT
//
// Fits a residual codebook to vectors, layer by layer.
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

}  // namespace qs
