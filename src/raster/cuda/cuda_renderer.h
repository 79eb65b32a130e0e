// SPDX-License-Identifier: MIT
//
// The CUDA backend, with pipelines `classic` (classic.cuh) and `fast` (fast/pipeline.cuh). Plain
// C++, so that whoever makes a renderer needs no CUDA headers.
#pragma once

#include <memory>

#include "raster/renderer.h"

namespace qs {

/// `device` counts the GPUs of gpu_report(). Throws Error(device) with the reason when that GPU
/// cannot be used. The renderer selects its GPU at every call, so any thread may own it.
std::unique_ptr<Renderer> make_cuda_renderer(ThreadPool& pool, int device);

}  // namespace qs
