// SPDX-License-Identifier: MIT
//
// LPIPS on a backend, and its weights.
#pragma once

#include <filesystem>
#include <functional>

#include "learn/lpips/lpips.h"
#include "raster/api/renderer.h"

namespace qs {

/// See lpips::Metric::distance(), which has the requirements of the images.
using LpipsDistance =
    std::function<double(const Image& a, const Image& b, lpips::InputRange range)>;

/// `pool` must outlive the result. `device` is an index into GpuReport::gpus; the CPU backend
/// ignores it. Throws Error(device), as the result does if memory is short.
LpipsDistance make_lpips(Backend backend, const lpips::Weights& weights, ThreadPool& pool,
                         int device);

/// The weights of LPIPS in a .safetensors file, as scripts/lpips_weights writes it: tensors
/// features.N.weight, features.N.bias and linK.weight, and the metadata `network`. Throws
/// Error(input): the file is damaged, names no known network, or lacks a tensor.
lpips::Weights read_lpips(const std::filesystem::path& path);

}  // namespace qs
