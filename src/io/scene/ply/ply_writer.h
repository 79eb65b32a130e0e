// SPDX-License-Identifier: MIT
//
// Writes the layout of INRIA's trainer, which every viewer reads: binary little endian floats x y z
// nx ny nz f_dc_* f_rest_* opacity scale_* rot_*, normals zero, f_rest channel-major. Lossless:
// reading the file returns the same cloud bit by bit. A comment says that this program wrote it.
#pragma once

#include <filesystem>

#include "raster/base/parallel.h"
#include "raster/base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

void write_ply(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool& pool,
               const Progress& progress);

/// True if write_ply() wrote the file.
bool is_own_ply(const std::filesystem::path& path);

}  // namespace qs
