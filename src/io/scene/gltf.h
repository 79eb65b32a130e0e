// SPDX-License-Identifier: MIT
//
// glTF 2.0, binary or not, with KHR_gaussian_splatting (ratified: linear SCALE; the draft's
// logarithms are detected) and KHR_gaussian_splatting_compression_spz_2. All Gaussians of the
// default scene are read, moved by the transforms of their nodes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "io/scene/reader.h"

namespace qs {

bool recognises_gltf(std::span<const std::byte> content, const std::filesystem::path& path);
void read_gltf(std::span<const std::byte> content, const std::filesystem::path& path,
               ThreadPool& pool, const ReadOptions& options, Scene& scene);

}  // namespace qs
