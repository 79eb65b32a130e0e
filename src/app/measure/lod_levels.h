// SPDX-License-Identifier: MIT
//
// Levels of detail that `bench --lod` measures: baselines that it makes of a scene, and rules that
// cut trees by other facts than their own gains.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "raster/pages/cut.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// A seeded uniform sample of `count` Gaussians, 1 to their number. The lost opacity x area goes
/// into opacity up to 0.99, the rest into the standard deviations.
GaussianCloud uniform_sample(const GaussianCloud& cloud, std::size_t count);

/// A tree of one page, with its nodes in order of breadth. `order`, by node, numbers the merges.
struct Octree {
  LodPages tree;
  std::vector<float> order;
};

/// The octree of a scene, built from below. On each level the cells are twice as large; a Gaussian
/// takes part once the cell is at least twice its longest standard deviation. Gaussians of one cell
/// become one, at most 65,535 at a time: mean and covariance of the mixture with weights opacity x
/// area, opacity = their sum / area up to 0.99, averaged SH. Merges have their order level by
/// level, within a level by weight x spread. At most 2^31 Gaussians, at least one.
Octree octree_of(const GaussianCloud& leaves, ThreadPool& pool);

/// Gains by size and distance: the longest axis of a node, two standard deviations, in pixels of
/// the nearest view. `views` must outlive it.
LodGain gain_by_distance(std::span<const LodView> views);

/// All nodes of a tree whose pages are all in memory, in their order.
GaussianCloud all_nodes(const LodPages& tree);

/// The nodes in view of the finest cut with at most `budget` of them. `in_view` has a value for
/// each of all_nodes().
LodCut cut_in_view(const LodPages& tree, const LodGain& gain, std::size_t budget,
                   const std::vector<bool>& in_view, ThreadPool& pool);

}  // namespace qs
