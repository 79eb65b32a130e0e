// SPDX-License-Identifier: MIT
//
// Writes .spz, see spz.h, in its frame RUB and with the precision of Niantic's own writer:
// positions in 1/4096 (coarser if a scene is larger than 2048), SH in 5 bits for degree 1 and 4
// bits for the others.
#pragma once

#include <filesystem>

#include "base/parallel.h"
#include "base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Version 3, one gzip stream: the version that nearly every reader supports.
void write_spz(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool& pool,
               const Progress& progress);

/// Version 4, zstd streams that can be read in parallel.
void write_spz_v4(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool& pool,
                  const Progress& progress);

}  // namespace qs
