// SPDX-License-Identifier: MIT
//
// The last step of every reader: fills a cloud in parallel, makes rotations unit quaternions, takes
// out Gaussians that no renderer could draw (NaN, infinite or absurd values) and says in whole
// sentences what was dropped or looks wrong. Afterwards the promises on GaussianCloud's members
// hold.
#pragma once

#include <cstddef>
#include <functional>

#include "io/scene/reader.h"
#include "raster/base/parallel.h"

namespace qs {

/// Calls fill(begin, end) for disjoint ranges that cover scene.cloud, which has its size already;
/// from several threads. Reports progress from `start` to 1. Throws Error(input) when no Gaussian
/// is left, Cancelled, and what `fill` throws.
void fill_cloud(Scene& scene, ThreadPool& pool, const Progress& progress, float start,
                const std::function<void(std::size_t begin, std::size_t end)>& fill);

/// For formats whose bytes can say "no rotation": `count` Gaussians were left unrotated.
void warn_of_missing_rotations(Scene& scene, std::size_t count);

}  // namespace qs
