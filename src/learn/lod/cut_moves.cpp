// SPDX-License-Identifier: MIT
#include "learn/lod/cut_moves.h"

namespace qs {
namespace {

constexpr int kSearched = 4;  // steps down from a node to the nodes that replace it

// The nodes of a cut that another cut lacks. They are taken one after the other.
class Left {
 public:
  Left(const LodPages& tree, const LodCut& cut, const LodCut& other) : masks_(tree.pages.size()) {
    for (const LodPart& part : cut.parts) masks_[part.page] = part.mask;
    for (const LodPart& part : other.parts)
      if (masks_[part.page].size() > 0) masks_[part.page] -= part.mask;
  }

  bool has(const LodMove& node) const {
    return masks_[node.page].size() > 0 && masks_[node.page][node.row];
  }

  bool take(const LodMove& node) {
    if (!has(node)) return false;
    masks_[node.page].toggle(node.row);
    return true;
  }

  std::vector<LodMove> nodes() const {
    std::vector<LodMove> nodes;
    for (std::uint32_t page = 0; page < masks_.size(); ++page)
      masks_[page].for_each([&](std::size_t row) {
        nodes.push_back({page, static_cast<std::uint32_t>(row)});
      });
    return nodes;
  }

 private:
  std::vector<GaussianSet> masks_;  // by page
};

class Groups {
 public:
  Groups(const LodPages& tree, const LodCut& from, const LodCut& to, ThreadPool& pool)
      : tree_(tree), pool_(pool), go_(tree, from, to), come_(tree, to, from) {}

  std::vector<LodMoves> all() {
    gather(come_, go_, &LodMoves::come, &LodMoves::go);  // fewer nodes first, for the budget
    gather(go_, come_, &LodMoves::go, &LodMoves::come);
    if (LodMoves rest{go_.nodes(), come_.nodes()}; !rest.go.empty() || !rest.come.empty())
      groups_.push_back(std::move(rest));
    return std::move(groups_);
  }

 private:
  using Side = std::vector<LodMove> LodMoves::*;

  // Calls visit(child) until it returns false. False if a child is not in memory.
  template <class Visit>
  bool for_children(const LodMove& node, const Visit& visit) const {
    const LodFacts& facts = tree_.pages[node.page]->nodes[node.row];
    const LodPlacement* const placement = tree_.placement(node.page);
    const std::uint64_t first = facts.first_child + (placement ? placement->base : 0);
    for (std::uint64_t child = first; child < first + facts.child_count; ++child) {
      const LodMove at{static_cast<std::uint32_t>(child / tree_.page_nodes),
                       static_cast<std::uint32_t>(child % tree_.page_nodes)};
      if (!tree_.pages[at.page]) return false;
      if (!visit(at)) return true;
    }
    return true;
  }

  // True if nodes of `others` are a few steps below the node.
  bool leads_to(const Left& others, LodMove node) const {
    for (int step = 0; step < kSearched; ++step) {
      const LodMove before = node;
      if (!tree_.pages[node.page]) return false;
      for_children(node, [&](const LodMove& child) {
        node = child;
        return false;
      });
      if (node.page == before.page && node.row == before.row) return false;  // a leaf
      if (others.has(node)) return true;
    }
    return false;
  }

  // A group for each node of `roots` that has nodes of `others` below it.
  void gather(Left& roots, Left& others, Side of_root, Side of_others) {
    const std::vector<LodMove> nodes = roots.nodes();
    std::vector<char> leads(nodes.size());
    pool_.for_each(nodes.size(), 256,
                   [&](std::size_t i) { leads[i] = leads_to(others, nodes[i]); });
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!leads[i]) continue;
      LodMoves group;
      (group.*of_root).push_back(nodes[i]);
      roots.take(nodes[i]);
      std::vector<LodMove> opened = {nodes[i]};
      while (!opened.empty()) {
        const LodMove node = opened.back();
        opened.pop_back();
        for_children(node, [&](const LodMove& child) {
          if (others.take(child))
            (group.*of_others).push_back(child);
          else
            opened.push_back(child);
          return true;
        });
      }
      groups_.push_back(std::move(group));
    }
  }

  const LodPages& tree_;
  ThreadPool& pool_;
  Left go_, come_;
  std::vector<LodMoves> groups_;
};

}  // namespace

std::vector<LodMoves> moves_between(const LodPages& tree, const LodCut& from, const LodCut& to,
                                    ThreadPool& pool) {
  return Groups(tree, from, to, pool).all();
}

}  // namespace qs
