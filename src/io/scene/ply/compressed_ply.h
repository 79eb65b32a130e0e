// SPDX-License-Identifier: MIT
//
// compressed.ply of PlayCanvas, SuperSplat and gsplat: 16 bytes per Gaussian, packed relative to
// the bounds of its chunk of 256, and optional SH in one byte per value. Source: the reader and
// writer of playcanvas/splat-transform and gsplat's exporter.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/parallel.h"
#include "io/cloud/scene.h"

namespace qs {

bool recognises_compressed_ply(std::span<const std::byte> content,
                               const std::filesystem::path& path);
void read_compressed_ply(std::span<const std::byte> content, const std::filesystem::path& path,
                         ThreadPool& pool, const ReadOptions& options, Scene& scene);

}  // namespace qs
