// SPDX-License-Identifier: MIT
//
// Reads .ksplat (GaussianSplats3D), version 0.1, compression levels 0 to 2. Layout: a header and
// section headers, then per section the lengths and centres of its buckets and one row per
// Gaussian. Each section's layout is computed from its header in 64 bits and checked against the
// file's size before anything is allocated.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/parallel.h"
#include "io/cloud/scene.h"

namespace qs {

bool recognises_ksplat(std::span<const std::byte> content, const std::filesystem::path& path);
void read_ksplat(std::span<const std::byte> content, const std::filesystem::path& path,
                 ThreadPool& pool, const ReadOptions& options, Scene& scene);

}  // namespace qs
