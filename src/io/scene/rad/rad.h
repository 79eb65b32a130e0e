// SPDX-License-Identifier: MIT
//
// RAD (Spark): a tree of levels of detail in chunks of 65,536 nodes, beside each other in a .rad
// file or in files of their own (.radc). The leaves are read. Source: rust/spark-lib/src/rad.rs of
// sparkjsdev/spark; the code is our own.
#pragma once

#include <vector>

#include "io/cloud/scene.h"
#include "raster/pages/lod_node.h"

namespace qs {

RecogniseScene recognises_rad;
ReadScene read_rad;

/// All nodes of a file that quadsplat lod wrote: its Gaussians are scene.cloud, in the file's
/// order.
struct RadLevels {
  std::vector<LodFacts> nodes;
  float footprint = 1;  ///< the smallest one, world units
};

/// Throws Error(input) if the file is damaged or another program wrote it.
RadLevels read_rad_levels(std::span<const std::byte> content, const std::filesystem::path& path,
                          ThreadPool& pool, Scene& scene);

}  // namespace qs
