// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "base/parallel.h"
#include "base/progress.h"

namespace qs {

inline constexpr std::size_t kStreamedLevels = 5;

/// Writes cuts of a tree of build_lod() into a folder as a streamed SOG: the leaves, then levels
/// with a quarter of the Gaussians of the level before, for twice its distance. Of the tree only
/// facts of its nodes are in memory, 72 bytes each. Throws Error(device) if they do not fit, and as
/// RadPages and write_streamed_sog().
void write_streamed_levels(const std::filesystem::path& tree, const std::filesystem::path& folder,
                           ThreadPool& pool, const Progress& progress);

}  // namespace qs
