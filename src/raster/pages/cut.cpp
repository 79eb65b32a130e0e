// SPDX-License-Identifier: MIT
#include "raster/pages/cut.h"

#include <algorithm>
#include <cmath>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "base/fail.h"

namespace qs {
namespace {

constexpr float kSmallestDepth = 1e-3f;  // of a ball around a camera, in depths of its near plane
constexpr float kLeastGain = std::numeric_limits<float>::min();  // of merged nodes
constexpr float kMostGain = std::numeric_limits<float>::max();
constexpr float kRound = 4;  // a round opens the nodes down to this part of the largest gain
constexpr std::size_t kLodGrain = 512;

// A node on the way down the tree.
struct Visit {
  std::uint32_t node = 0, parent = 0;  // parent: its visit
  float gain = 0;
  enum : std::uint8_t {
    closed,
    open,
    awaited
  } state = closed;  // awaited: its children are missing
};

class Descent {
 public:
  Descent(const LodPages& tree, const LodGain& gain, ThreadPool& pool)
      : tree_(tree), gain_(gain), pool_(pool), visits_(1) {}

  LodCut run(const LodLimit& limit, float guess) {
    const std::size_t budget = std::max<std::size_t>(limit.budget, 1);
    float low = budget >= tree_.count ? limit.gain
                : guess > 0           ? std::max(limit.gain, guess)
                                      : std::numeric_limits<float>::infinity();
    std::vector<std::uint32_t> next;
    enter(0, low, next);
    for (float most = 0;; low = std::max(limit.gain, most / kRound)) {
      const std::size_t before = count_;
      opened_.clear();
      std::erase_if(waiting_, [&](std::uint32_t v) {
        if (visits_[v].gain > low) next.push_back(v);
        return visits_[v].gain > low;
      });
      while (!next.empty()) {
        const std::size_t begin = visits_.size();
        for (const std::uint32_t v : next) open(v);
        next.clear();
        enter(begin, low, next);
      }
      if (count_ > budget) {
        close_beyond(budget - before);
        break;
      }
      most = 0;
      for (const std::uint32_t v : waiting_) most = std::max(most, visits_[v].gain);
      limit_ = most;
      if (most <= limit.gain) break;
    }
    return cut();
  }

 private:
  const LodNode& node(std::uint32_t i) const {
    return tree_.pages[i / tree_.page_nodes]->nodes[i % tree_.page_nodes];
  }

  // Sets the gains of the visits from `begin` on. Those above `low` are opened next.
  void enter(std::size_t begin, float low, std::vector<std::uint32_t>& next) {
    pool_.for_each(visits_.size() - begin, kLodGrain, [&](std::size_t k) {
      Visit& visit = visits_[begin + k];
      const LodPage& page = *tree_.pages[visit.node / tree_.page_nodes];
      const std::size_t row = visit.node % tree_.page_nodes;
      if (page.nodes[row].child_count == 0) return;
      const float gain = gain_(page, row);  // NaN in a damaged file
      visit.gain = gain > kLeastGain ? std::min(gain, kMostGain) : kLeastGain;
      if (visit.node != 0) visit.gain = std::min(visit.gain, visits_[visit.parent].gain);
    });
    for (std::size_t i = begin; i < visits_.size(); ++i)
      if (visits_[i].gain > 0)
        (visits_[i].gain > low ? next : waiting_).push_back(static_cast<std::uint32_t>(i));
  }

  void open(std::uint32_t v) {
    const std::uint32_t first = node(visits_[v].node).first_child;
    const std::uint32_t count = node(visits_[v].node).child_count;
    const std::size_t pages[] = {first / tree_.page_nodes, (first + count - 1) / tree_.page_nodes};
    bool is_there = true;
    for (std::size_t page = pages[0]; page <= pages[1]; ++page) {
      if (!tree_.dead.empty() && tree_.dead[page]) return;
      is_there = is_there && tree_.pages[page];
    }
    count_ += count - 1;
    opened_.push_back(v);
    visits_[v].state = is_there ? Visit::open : Visit::awaited;
    for (std::uint32_t child = first; is_there && child < first + count; ++child)
      visits_.push_back({child, v});
    if (visits_.size() > tree_.count) fail("a node of the tree is the child of several nodes");
  }

  // Closes the nodes that the last round opened, except the first ones that fit.
  void close_beyond(std::size_t room) {
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
      const Visit &x = visits_[a], &y = visits_[b];
      return x.gain != y.gain ? x.gain > y.gain : x.node < y.node;
    };
    auto first = opened_.begin(), end = opened_.end();
    while (first != end) {
      const auto middle = first + (end - first) / 2;
      std::nth_element(first, middle, end, before);
      std::size_t added = 0;
      for (auto v = first; v <= middle; ++v) added += node(visits_[*v].node).child_count - 1u;
      if (added <= room) {
        room -= added;
        first = middle + 1;
      } else {
        end = middle;
      }
    }
    limit_ = visits_[*first].gain;
    for (; first != opened_.end(); ++first) visits_[*first].state = Visit::closed;
  }

  LodCut cut() const {
    LodCut cut;
    cut.limit = limit_;
    std::vector<LodPart> all(tree_.pages.size()), missing(tree_.pages.size());
    for (const Visit& visit : visits_) {
      const Visit& parent = visits_[visit.parent];
      if (visit.node != 0 && parent.state != Visit::open) continue;
      const std::uint64_t row = visit.node % tree_.page_nodes;
      LodPart& part = all[visit.node / tree_.page_nodes];
      part.gain = std::max(part.gain, parent.gain);
      if (part.mask.empty()) part.mask.resize((tree_.page_nodes + 63) / 64);
      if (visit.state == Visit::open) continue;
      part.mask[row / 64] |= std::uint64_t{1} << row % 64;
      ++part.count;
      ++cut.count;
      if (visit.state == Visit::closed) continue;
      const LodNode& above = node(visit.node);
      for (std::uint64_t page = above.first_child / tree_.page_nodes;
           page <= (above.first_child + above.child_count - 1u) / tree_.page_nodes; ++page)
        if (!tree_.pages[page]) missing[page].gain += visit.gain;
    }
    for (std::uint32_t page = 0; page < all.size(); ++page) {
      all[page].page = missing[page].page = page;
      if (!all[page].mask.empty()) cut.parts.push_back(std::move(all[page]));
      if (missing[page].gain > 0) cut.missing.push_back(std::move(missing[page]));
    }
    std::ranges::stable_sort(cut.missing, std::ranges::greater(), &LodPart::gain);
    return cut;
  }

  const LodPages& tree_;
  const LodGain& gain_;
  ThreadPool& pool_;
  std::vector<Visit> visits_;
  std::vector<std::uint32_t> waiting_;  // visits of merged nodes that no round has opened
  std::vector<std::uint32_t> opened_;   // by the last round
  std::size_t count_ = 1;               // nodes of the cut, as if no page were missing
  float limit_ = 0;
};

}  // namespace

std::size_t LodPage::bytes() const {
  return cloud.size() * (sizeof(glm::vec3) * 2 + sizeof(glm::quat) + sizeof(float)) +
         cloud.sh.size() * sizeof(glm::vec3) + nodes.size() * sizeof(LodNode);
}

LodSight LodView::operator()(const glm::vec3& center, float radius) const {
  const glm::vec2 focal(camera.focal_px), middle(camera.center_px);
  const auto near = static_cast<float>(camera.near_depth), width = static_cast<float>(camera.width),
             height = static_cast<float>(camera.height);
  const glm::vec3 at(camera.view_from_world * glm::dvec4(glm::dvec3(center), 1));
  // The planes of the frustum: distance of the ball's centre to each, outward.
  const auto beyond = [&](float along, float f, float pixels) {
    return (along * f - at.z * pixels) / std::sqrt(f * f + pixels * pixels);
  };
  const float farthest = std::max(
      {near - at.z, beyond(at.x, focal.x, width - middle.x), beyond(-at.x, focal.x, middle.x + 1),
       beyond(at.y, focal.y, height - middle.y), beyond(-at.y, focal.y, middle.y + 1)});
  const bool is_inside = farthest <= radius;
  const float depth = (is_inside ? at.z : glm::length(at)) - radius;
  return {std::max(depth, kSmallestDepth * near) / std::sqrt(focal.x * focal.y),
          is_inside ? 1 : outside};
}

float lod_gain(const LodNode& node, float smallest, float footprint) {
  if (node.child_count == 0) return 0;
  const float place = std::clamp(std::log2(footprint / smallest) / std::log2(kLodFootprintRatio),
                                 0.0f, static_cast<float>(kLodFootprints - 1));
  const auto below = std::min(static_cast<std::size_t>(place), kLodFootprints - 2);
  const float part = place - static_cast<float>(below);
  const float step = static_cast<float>(node.gains[below]) * (1 - part) +
                     static_cast<float>(node.gains[below + 1]) * part;
  return smallest * smallest * std::exp2(step / 4 - 28) / (footprint * footprint);
}

LodGain gain_in(const LodView& view, float smallest) {
  return [=](const LodPage& page, std::size_t row) {
    const LodSight sight = view(page.cloud.positions[row], page.nodes[row].radius);
    if (smallest > 0) return sight.share * lod_gain(page.nodes[row], smallest, sight.footprint);
    const float pixels = page.nodes[row].radius / sight.footprint;
    return sight.share * pixels * pixels;
  };
}

LodCut cut_of(const LodPages& tree, const LodGain& gain, const LodLimit& limit, ThreadPool& pool,
              float guess) {
  return Descent(tree, gain, pool).run(limit, guess);
}

}  // namespace qs
