// SPDX-License-Identifier: MIT
//
// The CUDA backend, with the pipelines `classic` (classic/classic.cuh) and `fast`
// (fast/pipeline.cuh). This header is plain C++: users need no CUDA headers.
#pragma once

#include <memory>

#include "raster/api/renderer.h"

namespace qs {

/// `device` is an index into GpuReport::gpus. Throws Error(device) with the reason if that GPU
/// cannot be used. The renderer selects its GPU in every call, so any thread may call it.
std::unique_ptr<Renderer> make_cuda_renderer(ThreadPool& pool, int device);

}  // namespace qs
