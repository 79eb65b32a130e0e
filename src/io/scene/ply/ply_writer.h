// SPDX-License-Identifier: MIT
//
// Writes the layout of INRIA's trainer, which every viewer reads: binary little endian floats x y z
// nx ny nz f_dc_* f_rest_* opacity scale_* rot_*, normals zero, f_rest channel-major. Lossless:
// reading the file returns the same cloud bit by bit.
#pragma once

#include <filesystem>

#include "base/parallel.h"
#include "base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

void write_ply(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool& pool,
               const Progress& progress);

/// As write_ply(), with a comment that says that this program trained the model.
void write_trained_ply(const GaussianCloud& cloud, const std::filesystem::path& path,
                       ThreadPool& pool);

/// The line of the header of a file that this program trained.
inline constexpr const char* kTrainedComment = "comment trained by quadsplat\n";

/// True if the file has that comment.
bool is_trained_ply(const std::filesystem::path& path);

}  // namespace qs
