// SPDX-License-Identifier: MIT
//
// Copies between arrays of the caller on the context's GPU and the memory in which a function
// works. Without CUDA no context has a GPU, so nothing here is called.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "library/check/arrays.h"
#include "library/check/context.h"
#include "quadsplat/quadsplat.h"
#include "raster/api/renderer.h"

namespace qs::library {

/// The number of the GPU that has the array's data, if it is not the array's device. nullopt if
/// CUDA does not know it.
std::optional<int> other_gpu_of(const QsArray& array);

/// Copies of checked arrays on the host, for a call that reads them.
class HostCopies {
 public:
  /// `stream`: the cudaStream_t in which the arrays are ready.
  HostCopies(const Use& use, void* stream) : use_(use), stream_(stream) {}

  /// The array on the host with the same values; arrays in host memory stay. Waits. Valid as long
  /// as the object. Throws Error(device).
  QsArray of(const QsArray& array);

 private:
  const Use& use_;
  void* stream_;
  std::vector<std::vector<std::byte>> copies_;
};

/// Copies a frame's colours and depths from the renderer's memory into the checked arrays of
/// `picture` on the same GPU, in its stream. Waits. Throws Error(device).
void store_on_gpu(const DeviceMaps& maps, const QsPicture& picture, const Camera& camera,
                  const Use& use);

}  // namespace qs::library
