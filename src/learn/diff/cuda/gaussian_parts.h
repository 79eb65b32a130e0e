// SPDX-License-Identifier: MIT
//
// The parts of a trainer of learn/diff/gaussian_parts.h for arrays on the GPU.
#pragma once

#include <cstddef>

#include "learn/diff/cuda/frame.h"
#include "learn/diff/gaussian_parts.h"

namespace qs::cuda::diff {

/// Enqueues part(i) for all i < `count`. Throws Error(device).
template <class Part>
void enqueue(const Part& part, std::size_t count, const Queue& queue);

extern template void enqueue(const Covariances&, std::size_t, const Queue&);
extern template void enqueue(const RowScale<float>&, std::size_t, const Queue&);
extern template void enqueue(const NoisyMeans&, std::size_t, const Queue&);
extern template void enqueue(const ViewSums&, std::size_t, const Queue&);
extern template void enqueue(const Relocations<std::int32_t>&, std::size_t, const Queue&);
extern template void enqueue(const Relocations<std::uint32_t>&, std::size_t, const Queue&);
extern template void enqueue(const Relocations<std::int64_t>&, std::size_t, const Queue&);
extern template void enqueue(const Relocations<std::uint64_t>&, std::size_t, const Queue&);

}  // namespace qs::cuda::diff
