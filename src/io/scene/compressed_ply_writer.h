// SPDX-License-Identifier: MIT
//
// Writes compressed .ply, see compressed_ply.h. Gaussians are put in Morton order, so that the 256
// of a chunk lie close together and their values are stored finely.
#pragma once

#include <filesystem>

#include "raster/base/parallel.h"
#include "raster/base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

void write_compressed_ply(const GaussianCloud& cloud, const std::filesystem::path& path,
                          ThreadPool& pool, const Progress& progress);

}  // namespace qs
