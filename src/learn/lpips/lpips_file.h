// SPDX-License-Identifier: MIT
//
// The weights of LPIPS in a .safetensors file, as scripts/lpips_weights writes it: tensors
// features.N.weight, features.N.bias and linK.weight, and the metadata `network`.
#pragma once

#include <filesystem>

#include "learn/lpips/lpips.h"

namespace qs {

/// Throws Error(input): the file is damaged, names no known network, or lacks a tensor.
lpips::Weights read_lpips(const std::filesystem::path& path);

}  // namespace qs
