// SPDX-License-Identifier: MIT
//
// Writes binary glTF with KHR_gaussian_splatting as ratified: one mesh of points, all values
// floats, linear scales, in glTF's frame. Lossless except for rounding when logarithms are
// converted to values and back.
#pragma once

#include <filesystem>

#include "base/parallel.h"
#include "base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

void write_glb(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool& pool,
               const Progress& progress);

}  // namespace qs
