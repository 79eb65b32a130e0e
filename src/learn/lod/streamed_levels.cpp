// SPDX-License-Identifier: MIT
#include "learn/lod/streamed_levels.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "base/fail.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/rad/rad_pages.h"
#include "io/scene/sog/sog.h"
#include "learn/lod/cut.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

// Cuts of a file, of which only the facts of its nodes are in memory, and later the numbers.
class CutsOfFile {
 public:
  CutsOfFile(const std::filesystem::path& tree, ThreadPool& pool)
      : file_(tree), header_(file_.header()), pool_(pool) {
    const std::uint64_t bytes = header_.count * (sizeof(LodFacts) + sizeof(LodVisit));
    if (bytes > available_memory())
      fail(ErrorKind::device, "{}: its levels need {} of memory, and {} are available",
           tree.string(), bytes_text(bytes), bytes_text(available_memory()));
    LodPages facts{header_.count, header_.chunk_nodes, header_.footprint};
    facts.pages.resize(header_.chunks.size());
    pool.for_each(facts.pages.size(), 1, [&](std::size_t i) {
      facts.pages[i] = std::make_shared<const LodPage>(LodPage{{}, file_.read(i).nodes});
    });
    std::size_t budget = 0;  // first all leaves
    for (const auto& page : facts.pages)
      budget +=
          static_cast<std::size_t>(std::ranges::count(page->nodes, 0, &LodFacts::child_count));
    // The finest level is meant for pixels of the median Gaussian's standard deviation.
    float footprint = 16 * header_.footprint;
    for (std::size_t k = 0; k < kStreamedLevels; ++k, budget /= 4, footprint *= 2) {
      views_.push_back(even_view(footprint));
      const auto gain = [&](const LodPage& page, std::size_t row) {
        return lod_gain(page.nodes[row], header_.footprint, footprint);
      };
      std::vector<std::uint32_t>& nodes = nodes_.emplace_back();
      for (const LodPart& part : cut_of(facts, LodGain(gain), {budget}, pool).parts)
        part.for_each([&](std::size_t row) {
          nodes.push_back(static_cast<std::uint32_t>(part.page * header_.chunk_nodes + row));
        });
    }
  }

  SogLevel level(std::size_t k) const {
    SogLevel level;
    level.centers.resize(nodes_[k].size());
    level.sigmas.resize(nodes_[k].size());
    for_each_node(nodes_[k], [&](const LodPages& page, std::size_t row, std::size_t i) {
      GaussianCloud one = make_cloud(1, file_.sh_degree());
      put_node(page, 0, row, views_[k], dilation(), one, 0);
      const glm::vec3& s = one.log_scales[0];
      level.centers[i] = one.positions[0];
      level.sigmas[i] = std::exp(std::max({s.x, s.y, s.z}));
    });
    level.gaussians = [this, k](std::span<const std::uint32_t> numbers) {
      std::vector<std::uint32_t> order(numbers.size()), nodes;  // by node
      std::iota(order.begin(), order.end(), 0u);
      std::ranges::sort(order, {}, [&](std::uint32_t i) { return numbers[i]; });
      for (const std::uint32_t i : order) nodes.push_back(nodes_[k][numbers[i]]);
      GaussianCloud cloud = make_cloud(numbers.size(), file_.sh_degree());
      cloud.antialiased = header_.antialiased;
      for_each_node(nodes, [&](const LodPages& page, std::size_t row, std::size_t i) {
        put_node(page, 0, row, views_[k], dilation(), cloud, order[i]);
      });
      return cloud;
    };
    return level;
  }

 private:
  double dilation() const { return header_.antialiased ? 0 : static_cast<double>(kDilation); }

  // Calls use(page, row, i) for each of these nodes, which are in increasing order. `page`: a tree
  // of one page. Several threads call it.
  template <class Use>
  void for_each_node(std::span<const std::uint32_t> nodes, const Use& use) const {
    const auto page_of = [&](std::size_t i) { return nodes[i] / header_.chunk_nodes; };
    std::vector<std::size_t> first;  // of each page
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (i == 0 || page_of(i) != page_of(i - 1)) first.push_back(i);
    first.push_back(nodes.size());
    pool_.for_each(first.size() - 1, 1, [&](std::size_t p) {
      const LodPages page{0,
                          header_.chunk_nodes,
                          header_.footprint,
                          {std::make_shared<const LodPage>(file_.read(page_of(first[p])))}};
      for (std::size_t i = first[p]; i < first[p + 1]; ++i)
        use(page, nodes[i] % header_.chunk_nodes, i);
    });
  }

  RadPages file_;
  const RadHeader& header_;
  ThreadPool& pool_;
  std::vector<LodView> views_;                     // by level
  std::vector<std::vector<std::uint32_t>> nodes_;  // of each level, in increasing order
};

}  // namespace

void write_streamed_levels(const std::filesystem::path& tree, const std::filesystem::path& folder,
                           ThreadPool& pool, const Progress& progress) {
  const CutsOfFile cuts(tree, pool);
  std::vector<SogLevel> levels;
  for (std::size_t k = 0; k < kStreamedLevels; ++k) levels.push_back(cuts.level(k));
  write_streamed_sog(levels, folder, pool, progress);
}

}  // namespace qs
