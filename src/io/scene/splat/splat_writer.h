// SPDX-License-Identifier: MIT
//
// Writes .splat, see splat.h: the largest Gaussians first, as viewers that draw a file while
// downloading it expect. View-dependent colour is lost; base colours are clamped to 0..1.
#pragma once

#include <filesystem>

#include "base/parallel.h"
#include "base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

void write_splat(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool& pool,
                 const Progress& progress);

}  // namespace qs
