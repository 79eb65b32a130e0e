// SPDX-License-Identifier: MIT
//
// Distances of a caller's points on the GPU to their nearest neighbours.
#pragma once

#include <cstddef>

#include "learn/diff/cuda/frame.h"
#include "learn/diff/strided_arrays.h"

namespace qs::cuda::diff {

/// For each of `count` points, at most 2^31 - 1, the mean of the squared distances to its three
/// nearest neighbours, with the bits of the CPU. A point that is not finite has NaN, and is no
/// neighbour. Waits. Throws Error(device). `Real`: float or double.
template <class Real>
void neighbour_distances2(const Rows<const float>& points, std::size_t count, const Queue& queue,
                          const Rows<Real>& out);

extern template void neighbour_distances2(const Rows<const float>&, std::size_t, const Queue&,
                                          const Rows<float>&);
extern template void neighbour_distances2(const Rows<const float>&, std::size_t, const Queue&,
                                          const Rows<double>&);

}  // namespace qs::cuda::diff
