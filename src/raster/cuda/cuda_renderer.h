// SPDX-License-Identifier: MIT
//
// The CUDA backend, pipeline `classic`: preprocess, bin, sort, blend as published with 3DGS, each
// in the file of its name. Plain C++, so that whoever makes a renderer needs no CUDA headers.
#pragma once

#include <memory>

#include "raster/renderer.h"

namespace qs {

/// `device` counts the GPUs of gpu_report(). Throws Error(device) with the reason when that GPU
/// cannot be used. The renderer selects its GPU at every call, so any thread may own it.
std::unique_ptr<Renderer> make_cuda_renderer(int device);

}  // namespace qs
