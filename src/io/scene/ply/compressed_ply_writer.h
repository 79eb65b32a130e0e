// SPDX-License-Identifier: MIT
//
// Writes compressed .ply, see compressed_ply.h. Gaussians are sorted in Morton order: the 256 of a
// chunk are then close together, so that their bounds are tight and quantisation is fine.
#pragma once

#include <filesystem>

#include "base/parallel.h"
#include "base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

void write_compressed_ply(const GaussianCloud& cloud, const std::filesystem::path& path,
                          ThreadPool& pool, const Progress& progress);

}  // namespace qs
