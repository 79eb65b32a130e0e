// SPDX-License-Identifier: MIT
//
// A cut of a tree: the nodes that are drawn in the place of all leaves. A node is in the cut if its
// gain is at most a limit and its parent's gain is above; the limit follows from the budget.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "learn/lod/merging.h"
#include "raster/pages/cut.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// A merged node of a file as it was before it was drawn, without its mean and colours.
LodGaussian merged_node(const GaussianCloud& nodes, std::size_t i, const LodFacts& node);

// Nodes in a view. `dilation` is the variance of the renderer's filter, px^2; 0 if it keeps the
// light of each Gaussian (antialiased).

/// The variance of the filter at a node that is fitted to it, world units^2; 0 for other nodes.
float filter_variance(const LodPages& tree, std::size_t page, std::size_t row, const LodView& view,
                      double dilation);

/// Stores a node as Gaussian `k` of `cloud`, as it is drawn. Returns its filter_variance().
float put_node(const LodPages& tree, std::size_t page, std::size_t row, const LodView& view,
               double dilation, GaussianCloud& cloud, std::size_t k);

/// The place of each node of a cut, by page and row, among the Gaussians of its cloud. Leaves whose
/// numbers in the sources are known come first, by number; the others have the order of the file.
class CutPlaces {
 public:
  CutPlaces(const LodPages& tree, const LodCut& cut);

  std::size_t operator[](std::size_t k) const { return places_.empty() ? k : places_[k]; }

 private:
  std::vector<std::uint32_t> places_;  // empty: the order of the file
};

/// The first node of each part of a cut, and the number of all nodes.
std::vector<std::size_t> starts_of_parts(const LodCut& cut);

/// The Gaussians of the cut of a view, at their CutPlaces, with SH up to `degree`; and copies of
/// the last one until there are `least`. `variances`: the filter_variance() of each; null: not
/// stored.
GaussianCloud cut_cloud(const LodPages& tree, const LodCut& cut, const LodView& view,
                        double dilation, ThreadPool& pool, std::vector<float>* variances = nullptr,
                        int degree = kMaxShDegree, std::size_t least = 0);

}  // namespace qs
