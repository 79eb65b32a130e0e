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

/// The sums of the gains in these views.
inline LodGain gain_in_all(const std::vector<LodView>& views, float smallest) {
  std::vector<LodGain> gains;
  for (const LodView& view : views) gains.push_back(gain_in(view, smallest));
  return LodGain([gains](std::span<LodAsked> nodes) {
    std::vector<float> sums(nodes.size());
    for (const LodGain& gain : gains) {
      gain(nodes);
      for (std::size_t k = 0; k < nodes.size(); ++k) sums[k] += nodes[k].gain;
    }
    for (std::size_t k = 0; k < nodes.size(); ++k) nodes[k].gain = sums[k];
  });
}

}  // namespace qs::test
