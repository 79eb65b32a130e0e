// SPDX-License-Identifier: MIT
#include "learn/lod/streamed_levels.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "io/bytes/mapped_file.h"
#include "io/scene/sog/sog.h"
#include "learn/lod/cut.h"

namespace qs {

void write_streamed_levels(const std::filesystem::path& tree, const std::filesystem::path& folder,
                           ThreadPool& pool, const Progress& progress) {
  std::vector<GaussianCloud> levels;
  {
    Scene nodes;
    const MappedFile file(tree);
    const RadLevels facts = read_rad_levels(file.content(), tree, pool, nodes);
    const std::uint64_t count = facts.nodes.size();
    const auto page = std::make_shared<const LodPage>(LodPage{{}, facts.nodes});
    const LodPages one_page{count, count, facts.footprint, {page}};
    auto budget =
        static_cast<std::size_t>(std::ranges::count(facts.nodes, 0, &LodFacts::child_count));
    // The finest level is meant for pixels of the median Gaussian's standard deviation.
    float footprint = 16 * facts.footprint;
    for (std::size_t k = 0; k < kStreamedLevels; ++k, budget /= 4, footprint *= 2) {
      const auto gain = [&](const LodPage&, std::size_t row) {
        return lod_gain(facts.nodes[row], facts.footprint, footprint);
      };
      std::vector<std::uint32_t> cut;
      cut_of(one_page, gain, {std::max<std::size_t>(budget, 1)}, pool)
          .parts[0]
          .for_each([&](std::size_t row) { cut.push_back(static_cast<std::uint32_t>(row)); });
      levels.push_back(
          cut_cloud(facts, nodes.cloud, cut, {std::vector<float>(count, footprint), {}}));
    }
  }
  write_streamed_sog(levels, folder, pool, progress);
}

}  // namespace qs
