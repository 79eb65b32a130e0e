// SPDX-License-Identifier: MIT
//
// The last step of every reader: fills a cloud in parallel, normalises rotations, removes Gaussians
// that no renderer can draw (NaN, infinite or absurdly large values) and adds warnings about
// removed Gaussians and suspicious values. Afterwards the invariants documented on GaussianCloud's
// members hold.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "base/parallel.h"
#include "io/cloud/scene.h"

namespace qs {

using Fill = std::function<void(std::size_t begin, std::size_t end)>;

/// Calls fill(begin, end) from several threads for disjoint ranges that cover scene.cloud, which
/// already has its size. Reports progress from `start` to 1. Throws Error(input) if no Gaussian is
/// left, Cancelled, and anything that `fill` throws.
void fill_cloud(Scene& scene, ThreadPool& pool, const Progress& progress, float start,
                const Fill& fill);

/// As fill_cloud(), for values that come from no file: adds no warnings, and may leave no Gaussian.
/// Returns the indices of the removed Gaussians, in increasing order. Throws Cancelled, and
/// anything that `fill` throws.
std::vector<std::size_t> fill_drawable(GaussianCloud& cloud, ThreadPool& pool,
                                       const Progress& progress, const Fill& fill);

/// Adds a warning that `count` Gaussians have no valid rotation and got the identity.
void warn_of_missing_rotations(Scene& scene, std::size_t count);

}  // namespace qs
