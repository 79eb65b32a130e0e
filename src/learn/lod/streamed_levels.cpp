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

  // Reads each page once for all centres and sizes.
  std::vector<SogLevel> levels() const {
    std::vector<SogLevel> levels(nodes_.size());
    for (std::size_t k = 0; k < levels.size(); ++k) {
      levels[k].centers.resize(nodes_[k].size());
      levels[k].sigmas.resize(nodes_[k].size());
      levels[k].gaussians = [this, k](std::span<const std::uint32_t> numbers) {
        return gaussians(k, numbers);
      };
    }
    pool_.for_each(header_.chunks.size(), 1, [&](std::size_t p) {
      const LodPages page = page_alone(p);
      GaussianCloud one = make_cloud(1, file_.sh_degree());
      for (std::size_t k = 0; k < levels.size(); ++k) {
        auto node = std::ranges::lower_bound(nodes_[k], p * header_.chunk_nodes);
        for (; node != nodes_[k].end() && *node / header_.chunk_nodes == p; ++node) {
          put_node(page, 0, *node % header_.chunk_nodes, views_[k], dilation(), one, 0);
          const glm::vec3& s = one.log_scales[0];
          const auto i = static_cast<std::size_t>(node - nodes_[k].begin());
          levels[k].centers[i] = one.positions[0];
          levels[k].sigmas[i] = std::exp(std::max({s.x, s.y, s.z}));
        }
      }
    });
    return levels;
  }

 private:
  double dilation() const { return header_.antialiased ? 0 : static_cast<double>(kDilation); }

  // A tree of one page.
  LodPages page_alone(std::size_t p) const {
    return {0,
            header_.chunk_nodes,
            header_.footprint,
            {std::make_shared<const LodPage>(file_.read(p))}};
  }

  // The Gaussians of a level with these numbers. Each of their pages is read once.
  GaussianCloud gaussians(std::size_t k, std::span<const std::uint32_t> numbers) const {
    const auto node_of = [&](std::uint32_t i) { return nodes_[k][numbers[i]]; };
    const auto page_of = [&](std::uint32_t i) { return node_of(i) / header_.chunk_nodes; };
    std::vector<std::uint32_t> order(numbers.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, node_of);
    std::vector<std::span<const std::uint32_t>> parts;  // of a page each
    for (auto begin = order.begin(); begin != order.end();) {
      const auto end = std::ranges::upper_bound(begin, order.end(), page_of(*begin), {}, page_of);
      parts.emplace_back(begin, end);
      begin = end;
    }
    GaussianCloud cloud = make_cloud(numbers.size(), file_.sh_degree());
    cloud.antialiased = header_.antialiased;
    pool_.for_each(parts.size(), 1, [&](std::size_t p) {
      const LodPages page = page_alone(page_of(parts[p].front()));
      for (const std::uint32_t i : parts[p])
        put_node(page, 0, node_of(i) % header_.chunk_nodes, views_[k], dilation(), cloud, i);
    });
    return cloud;
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
  write_streamed_sog(cuts.levels(), folder, pool, progress);
}

}  // namespace qs
