// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/gaussian_parts.h"

namespace qs::cuda::diff {

template <class Part>
void enqueue(const Part& part, std::size_t count, const Queue& queue) {
  for_each_item("gaussians", count, stream_of(queue), [=] __device__(std::size_t i) { part(i); });
}

template void enqueue(const Covariances&, std::size_t, const Queue&);
template void enqueue(const RowScale<float>&, std::size_t, const Queue&);
template void enqueue(const NoisyMeans&, std::size_t, const Queue&);
template void enqueue(const ViewSums&, std::size_t, const Queue&);
template void enqueue(const Relocations<std::int32_t>&, std::size_t, const Queue&);
template void enqueue(const Relocations<std::uint32_t>&, std::size_t, const Queue&);
template void enqueue(const Relocations<std::int64_t>&, std::size_t, const Queue&);
template void enqueue(const Relocations<std::uint64_t>&, std::size_t, const Queue&);

}  // namespace qs::cuda::diff
