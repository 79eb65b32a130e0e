// SPDX-License-Identifier: MIT
//
// Whole trees in memory, and their cuts.
#pragma once

#include <filesystem>
#include <vector>

#include "io/scene/reader.h"
#include "raster/pages/page_stream.h"
#include "support/pool.h"

namespace qs::test {

/// All pages of a tree's file, as it has them.
inline LodPages whole_tree(const std::filesystem::path& file) {
  ReadOptions options;
  options.keeps_place = true;
  options.streams = StreamedTrees::all;
  return read_scene(file, pool(), options).stream->whole_tree(pool());
}

}  // namespace qs::test
