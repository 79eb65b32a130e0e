// SPDX-License-Identifier: MIT
//
// Levels of detail that `bench --lod` measures: baselines that it makes of a scene, and cuts of
// trees of Gaussians. A cut draws each leaf or exactly one of the nodes above it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// A seeded uniform sample of `count` Gaussians, 1 to their number. The lost opacity x area goes
/// into opacity up to 0.99, the rest into the standard deviations.
GaussianCloud uniform_sample(const GaussianCloud& cloud, std::size_t count);

/// Leaves and merged Gaussians. Either all parents come before their children, or all after them.
struct NodeTree {
  std::shared_ptr<const GaussianCloud> nodes;
  std::vector<std::uint32_t> parents;  ///< by node; kNoParent for the root
  std::vector<double> order = {};  ///< by node: see octree_of(); empty for trees of other origin
};

/// The octree of a scene, built from below. The leaves come first, in their order. On each level
/// the cells are twice as large; a Gaussian takes part once the cell is at least twice its longest
/// standard deviation. Gaussians of one cell become one: mean and covariance of the mixture with
/// weights opacity x area, opacity = their sum / area up to 0.99, averaged SH. `order` numbers the
/// merges: level by level, within a level by weight x spread. At most 2^31 Gaussians, at least one.
NodeTree octree_of(const GaussianCloud& leaves, ThreadPool& pool);

/// The error of each node by a rule of size and distance: the longest axis, two standard
/// deviations, in pixels of the camera that is nearest to the node. 0 for leaves.
std::vector<double> pixel_sizes(const NodeTree& tree, std::span<const Camera> cameras);

/// The cut by a threshold: going down from the root, the first nodes whose error is at most that.
/// The threshold is the least for which at most `budget` nodes of the cut count; `counts` has a
/// value per node, and all count if it is empty. Returns the nodes that count, in increasing order.
std::vector<std::uint32_t> cut_of(const NodeTree& tree, std::span<const double> errors,
                                  std::size_t budget, const std::vector<bool>& counts = {});

}  // namespace qs
