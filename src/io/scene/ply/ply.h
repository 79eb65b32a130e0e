// SPDX-License-Identifier: MIT
//
// Reads splats as trainers save them: a .ply whose element "vertex" has x y z, f_dc_*, f_rest_*,
// opacity, scale_* and rot_* (INRIA, gsplat, Brush, PlayCanvas, 2DGS, ...). Properties are found by
// name, in any order and of any type; unknown properties are skipped. f_rest is channel-major: all
// red coefficients first.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "base/parallel.h"
#include "io/cloud/scene.h"
#include "io/scene/ply/ply_header.h"

namespace qs {

/// True for Gaussians without colours, as Compact-3DGS saves them. Point clouds and meshes are not.
bool is_ply_without_colors(std::span<const std::byte> content);

bool recognises_ply(std::span<const std::byte> content, const std::filesystem::path& path);
void read_ply(std::span<const std::byte> content, const std::filesystem::path& path,
              ThreadPool& pool, const ReadOptions& options, Scene& scene);

/// SH coefficients per channel beyond DC, given the number for all channels together: 0, 3, 8, 15
/// or 24; -1 if the number fits no degree.
int sh_rest_per_channel(std::size_t values);

/// The SH degree to keep, given sh_rest_per_channel() of 0, 3, 8, 15 or 24. Degree 4 is reduced to
/// 3 with a warning.
int kept_sh_degree(int rest_per_channel, Scene& scene);

/// Applies the declarations in the header's comments: antialiased training, the vertical axis.
void apply_ply_comments(const PlyHeader& header, Scene& scene);

}  // namespace qs
