// SPDX-License-Identifier: MIT
#include "learn/lod/streamed_levels.h"

#include <algorithm>
#include <vector>

#include "io/scene/reader.h"
#include "io/scene/sog/sog.h"
#include "learn/lod/cut.h"
#include "raster/kernel/constants.h"
#include "raster/pages/page_stream.h"

namespace qs {

void write_streamed_levels(const std::filesystem::path& tree, const std::filesystem::path& folder,
                           ThreadPool& pool, const Progress& progress) {
  std::vector<GaussianCloud> levels;
  {
    ReadOptions options;
    options.keeps_place = true;
    options.streams = StreamedTrees::all;
    const LodPages whole = read_scene(tree, pool, options).stream->whole_tree(pool);
    std::size_t budget = 0;
    for (const auto& page : whole.pages)
      budget +=
          static_cast<std::size_t>(std::ranges::count(page->nodes, 0, &LodFacts::child_count));
    // The finest level is meant for pixels of the median Gaussian's standard deviation.
    float footprint = 16 * whole.footprint;
    const double dilation = whole.pages[0]->cloud.antialiased ? 0 : static_cast<double>(kDilation);
    for (std::size_t k = 0; k < kStreamedLevels; ++k, budget /= 4, footprint *= 2) {
      const LodView view = even_view(footprint);
      const LodCut cut = cut_of(whole, gain_in(view, whole.footprint), {budget}, pool);
      levels.push_back(cut_cloud(whole, cut, view, dilation, pool));
    }
  }
  write_streamed_sog(levels, folder, pool, progress);
}

}  // namespace qs
