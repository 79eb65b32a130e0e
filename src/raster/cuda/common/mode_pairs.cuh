// SPDX-License-Identifier: MIT
//
// Counts the tile pairs of every mode for one view (Outputs::mode_pairs): a kernel of its own
// behind the frame, for both pipelines, so frames without it run no other kernels. Nothing is
// listed, sorted or blended. The copy to the host is enqueued too, so the host waits for it
// together with the frame.
#pragma once

#include <optional>
#include <vector>

#include "raster/cuda/common/frame_context.cuh"
#include "raster/kernel/cull/mode_pairs.h"

namespace qs::cuda {

class ModeCounter {
 public:
  /// Enqueues the count of the Gaussians in `cloud` and the copy of its result. A frame that is
  /// drawn again may enqueue it again. Throws Error(device).
  void enqueue(const DeviceCloud& cloud, const CountedView& counted, cudaStream_t stream);

  /// Frame::mode_pairs of the last enqueue(), whose stream has finished.
  std::vector<ModePairs> result() const;

 private:
  // Made when they are first needed.
  DeviceBuffer<ModeCounts> counts_;
  std::optional<PinnedValue<ModeCounts>> on_host_;
};

}  // namespace qs::cuda
