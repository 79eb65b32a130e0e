// SPDX-License-Identifier: MIT
//
// Builds a tree with levels of detail of scenes that need not fit into memory:
//   1. reads the scenes: bounds, and a sample of the centres
//   2. reads them again and sorts the Gaussians into buckets on the disk, ranges of a Morton curve
//   3. makes the trees of each bucket, several buckets at a time
//   4. makes the tree over the roots of the buckets
//   5. writes the .rad file
// A folder beside the output keeps the finished buckets, so that the same call after an
// interruption goes on. The result depends on the inputs and the options, never on threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "base/progress.h"

namespace qs {

struct LodBuild {
  /// Each must fit into memory, except binary .ply files and instances, which are read in parts.
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path output;
  /// Bytes for the buckets that are worked on, at least 64 MB; 0: by the threads and the system.
  std::uint64_t memory = 0;
  std::string axes;       ///< as ReadOptions::axes
  bool original = false;  ///< the file keeps the bits and the order of the leaves, too
  Progress progress;
  /// Receives warnings of the readers, and a sentence if the call goes on with an interrupted one.
  std::function<void(const std::string& sentence)> warn;
};

struct LodReport {
  std::uint64_t leaves = 0, nodes = 0;
  std::size_t buckets = 0;
  int sh_degree = 0;
  glm::dvec3 origin{0.0};  ///< GaussianCloud::origin of the tree
};

/// Throws Error(input) if a scene cannot be read or the disk is full, Cancelled, and as
/// replace_file().
LodReport build_lod(const LodBuild& build, ThreadPool& pool);

}  // namespace qs
