// SPDX-License-Identifier: MIT
#include "learn/lod/cut_slots.h"

#include "io/cloud/cloud_memory.h"
#include "learn/lod/cut.h"

namespace qs {
namespace {

constexpr std::uint32_t kTurns = 8;  // calls until all pages were looked at
constexpr std::size_t kLeastSpare = 1024;

struct SlottedNode {
  std::uint32_t page, row, slot;
};

std::vector<const LodPart*> by_page(const LodCut& cut, std::size_t pages) {
  std::vector<const LodPart*> parts(pages);
  for (const LodPart& part : cut.parts) parts[part.page] = &part;
  return parts;
}

bool has(const std::vector<const LodPart*>& parts, std::uint32_t page, std::size_t row) {
  return parts[page] != nullptr && (parts[page]->mask[row / 64] >> row % 64 & 1) != 0;
}

}  // namespace

CutChange CutSlots::whole(const StreamedCut& made, const LodView& view, double dilation,
                          ThreadPool& pool) {
  CutChange change;
  GaussianCloud& cloud = change.whole;
  cloud = cut_cloud(made.tree, made.cut, view, dilation, pool, &variances_);
  const std::size_t count = cloud.size(), slots = count + count / 4 + kLeastSpare;
  cloud.resize(slots, cloud.sh_degree);
  variances_.resize(slots);
  free_.clear();
  drawn_ = GaussianSet(slots);
  for (std::size_t slot = slots; slot-- > count;) {
    copy_gaussian(cloud, count - 1, cloud, slot);
    free_.push_back(static_cast<std::uint32_t>(slot));
  }
  slots_.assign(made.tree.pages.size(), {});
  const CutPlaces places(made.tree, made.cut);
  std::uint32_t node = 0;
  for (const LodPart& part : made.cut.parts) {
    slots_[part.page].resize(made.tree.page_nodes);
    part.for_each([&](std::size_t row) {
      drawn_.add(node);
      slots_[part.page][row] = static_cast<std::uint32_t>(places[node++]);
    });
  }
  return change;
}

CutChange CutSlots::follow(const StreamedCut& made, const LodView& view, double dilation,
                           bool exact, ThreadPool& pool) {
  CutChange change;
  if (exact || made.cut.count > drawn_.size()) {
    change = whole(made, view, dilation, pool);
  } else {
    const LodPages& tree = made.tree;
    turn_ = (turn_ + 1) % kTurns;
    std::vector<SlottedNode> changed;
    const auto before = by_page(shown_, tree.pages.size()),
               now = by_page(made.cut, tree.pages.size());
    for (const LodPart& part : shown_.parts) {
      std::vector<std::uint32_t>& slots = slots_[part.page];
      part.for_each([&](std::size_t row) {
        if (has(now, part.page, row)) return;
        free_.push_back(slots[row]);
        drawn_.toggle(slots[row]);
      });
      if (!now[part.page]) slots = {};
    }
    for (const LodPart& part : made.cut.parts) {
      std::vector<std::uint32_t>& slots = slots_[part.page];
      slots.resize(tree.page_nodes);
      part.for_each([&](std::size_t row) {
        if (!has(before, part.page, row)) {
          slots[row] = free_.back();
          free_.pop_back();
          drawn_.toggle(slots[row]);
        } else if (part.page % kTurns == turn_) {
          const float fitted = variances_[slots[row]];
          const float variance = filter_variance(tree, part.page, row, view, dilation);
          if (variance <= kRefit * fitted && kRefit * variance >= fitted) return;
        } else {
          return;
        }
        changed.push_back({part.page, static_cast<std::uint32_t>(row), slots[row]});
      });
    }
    change.gaussians = make_cloud(changed.size(), tree.pages[0]->cloud.sh_degree);
    change.slots.resize(changed.size());
    pool.for_each(changed.size(), 256, [&](std::size_t k) {
      const SlottedNode& node = changed[k];
      change.slots[k] = node.slot;
      variances_[node.slot] =
          put_node(tree, node.page, node.row, view, dilation, change.gaussians, k);
    });
  }
  change.drawn = drawn_;
  change.selected = GaussianSet(drawn_.size());
  for (const LodPart& part : made.cut.parts)
    if (const GaussianSet& selected = made.tree.pages[part.page]->selected; selected.size() > 0)
      part.for_each([&](std::size_t row) {
        if (selected[row]) change.selected.add(slots_[part.page][row]);
      });
  shown_ = made.cut;
  return change;
}

}  // namespace qs
