// SPDX-License-Identifier: MIT
//
// Reads glTF 2.0 (.glb and .gltf) with KHR_gaussian_splatting (as ratified, with linear SCALE; the
// logarithms of its draft are detected) and KHR_gaussian_splatting_compression_spz_2. Reads all
// Gaussians of the default scene and applies the transforms of their nodes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/parallel.h"
#include "io/cloud/scene.h"

namespace qs {

bool recognises_gltf(std::span<const std::byte> content, const std::filesystem::path& path);
void read_gltf(std::span<const std::byte> content, const std::filesystem::path& path,
               ThreadPool& pool, const ReadOptions& options, Scene& scene);

}  // namespace qs
