// SPDX-License-Identifier: MIT
#include "learn/lod/cut_slots.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "io/cloud/cloud_memory.h"
#include "learn/lod/cut.h"
#include "learn/lod/cut_moves.h"

namespace qs {
namespace {

constexpr std::uint32_t kTurns = 8;  // calls until all pages were looked at
constexpr std::size_t kLeastSpare = 1024;

constexpr std::size_t kParts = 64;  // of the nodes of a cut; a part of a step has one
constexpr std::size_t kLeastPart = 256;

struct SlottedNode {
  std::uint32_t page, row, slot;
};

bool has(const LodPart* part, std::size_t row) { return part != nullptr && part->mask[row]; }

}  // namespace

CutChange CutSlots::whole(const StreamedCut& made, const LodView& view, double dilation,
                          ThreadPool& pool) {
  const std::size_t count = made.cut.count, slots = count + count / 4 + kLeastSpare;
  CutChange change;
  change.whole = std::make_shared<GaussianCloud>(
      cut_cloud(made.tree, made.cut, view, dilation, pool, &variances_, kMaxShDegree, slots));
  drawn_ = GaussianSet::where(slots, pool, [&](std::size_t slot) { return slot < count; });
  free_.resize(slots - count);
  std::iota(free_.rbegin(), free_.rend(), static_cast<std::uint32_t>(count));
  slots_.assign(made.tree.pages.size(), {});
  const CutPlaces places(made.tree, made.cut);
  const std::vector<std::size_t> starts = starts_of_parts(made.cut);
  pool.for_each(made.cut.parts.size(), 1, [&](std::size_t p) {
    const LodPart& part = made.cut.parts[p];
    std::size_t node = starts[p];
    slots_[part.page].resize(made.tree.page_nodes);
    part.for_each([&](std::size_t row) {
      slots_[part.page][row] = static_cast<std::uint32_t>(places[node++]);
    });
  });
  change.drawn = drawn_;
  return change;
}

CutChange CutSlots::parts(const StreamedCut& made, const LodView& view, double dilation,
                          ThreadPool& pool) {
  CutChange change;
  const LodPages& tree = made.tree;
  const std::size_t most = std::max(made.cut.count / kParts, kLeastPart);
  std::vector<SlottedNode> changed;  // of the part
  CutPart part;
  const auto end_part = [&] {
    if (changed.empty() && part.toggled.empty()) return;
    part.gaussians = make_cloud(changed.size(), tree.pages[0]->cloud.sh_degree);
    part.slots.resize(changed.size());
    pool.for_each(changed.size(), 256, [&](std::size_t k) {
      const SlottedNode& node = changed[k];
      part.slots[k] = node.slot;
      variances_[node.slot] =
          put_node(tree, node.page, node.row, view, dilation, part.gaussians, k);
    });
    change.parts.push_back(std::move(part));
    part = {};
    changed.clear();
  };
  const auto go = [&](const LodMoves& moves) {
    for (const LodMove& node : moves.go) {
      const std::uint32_t slot = slots_[node.page][node.row];
      free_.push_back(slot);
      drawn_.toggle(slot);
      part.toggled.push_back(slot);
    }
  };
  const auto come = [&](const LodMoves& moves) {
    for (const LodMove& node : moves.come) {
      slots_[node.page].resize(tree.page_nodes);
      const std::uint32_t slot = slots_[node.page][node.row] = free_.back();
      free_.pop_back();
      drawn_.toggle(slot);
      part.toggled.push_back(slot);
      changed.push_back({node.page, node.row, slot});
    }
  };
  const std::vector<LodMoves> steps = moves_between(tree, shown_, made.cut, pool);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (free_.size() + steps[i].go.size() < steps[i].come.size()) {  // all others at once
      const std::span rest = std::span(steps).subspan(i);
      std::ranges::for_each(rest, go);
      std::ranges::for_each(rest, come);
      break;
    }
    go(steps[i]);
    come(steps[i]);
    if (part.toggled.size() >= most) end_part();
  }
  end_part();
  // Opacities of nodes that stay.
  turn_ = (turn_ + 1) % kTurns;
  std::vector<const LodPart*> before(tree.pages.size()), now(tree.pages.size());
  for (const LodPart& old : shown_.parts) before[old.page] = &old;
  for (const LodPart& own : made.cut.parts) {
    now[own.page] = &own;
    if (own.page % kTurns != turn_) continue;
    own.for_each([&](std::size_t row) {
      if (!has(before[own.page], row)) return;
      const std::uint32_t slot = slots_[own.page][row];
      const float fitted = variances_[slot];
      const float variance = filter_variance(tree, own.page, row, view, dilation);
      if (variance <= kRefit * fitted && kRefit * variance >= fitted) return;
      changed.push_back({own.page, static_cast<std::uint32_t>(row), slot});
      if (changed.size() >= most) end_part();
    });
  }
  end_part();
  for (const LodPart& old : shown_.parts)
    if (!now[old.page]) slots_[old.page] = {};
  return change;
}

CutChange CutSlots::follow(const StreamedCut& made, const LodView& view, double dilation,
                           bool exact, ThreadPool& pool) {
  CutChange change = exact || made.cut.count > drawn_.size() ? whole(made, view, dilation, pool)
                                                             : parts(made, view, dilation, pool);
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
