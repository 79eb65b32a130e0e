// SPDX-License-Identifier: MIT
//
// A section of a scene's tree: the trees over the leaves of one bucket, or the tree over the roots
// of all buckets. Made on one thread; sections are made in parallel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "io/scene/rad/rad_writer.h"
#include "learn/lod/pair_tree.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Gaussian `i` as an item that is a leaf.
LodGaussian item_of(const GaussianCloud& cloud, std::size_t i);

/// Nodes without parents.
struct LodItems {
  std::vector<LodGaussian> gaussians;
  std::vector<NodeLevels> levels;
  RadNodes drawn;

  std::size_t size() const { return gaussians.size(); }
  /// Adds Gaussian `i`, a node with these facts, whose steps count from `footprint`.
  void add(const GaussianCloud& cloud, std::size_t i, const LodFacts& facts, float footprint);
  void append(const LodItems& other);
};

struct SectionOptions {
  float footprint = 1;  ///< the smallest one
  bool antialiased = false;
};

/// Nodes in the order of flattened(). Parents and first children count from the first node.
struct LodSection {
  RadNodes tree;
  LodItems roots;                    ///< their first nodes
  std::vector<std::uint32_t> items;  ///< per node: the number of its item, or ~0 for a merged node
};

/// Merges the items until at most `roots` are left. Nodes that are items keep their children.
LodSection make_section(LodItems items, std::size_t roots, const SectionOptions& options);

/// A file of this process: it may be read only by the program that wrote it. Throws Error(input).
void write_section(const std::filesystem::path& path, const LodSection& section);
LodSection read_section(const std::filesystem::path& path, bool roots_only);

/// The number of nodes in such a file.
std::uint64_t section_nodes(const std::filesystem::path& path);

}  // namespace qs
