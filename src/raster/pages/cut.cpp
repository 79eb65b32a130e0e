// SPDX-License-Identifier: MIT
#include "raster/pages/cut.h"

#include <algorithm>
#include <bit>
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
constexpr float kRoundOfGuess = 1.2f;  // the same below a guess
constexpr std::size_t kLodGrain = 512;

// A node on the way down the tree.
struct Visit {
  std::uint32_t node, parent;  // parent: its visit
  std::uint32_t first_child;
  float gain;  // 0: it stays closed, as leaves do
  std::uint16_t children;
  bool is_awaited;  // it was opened, and its children are missing

  std::uint32_t added() const { return children - 1u; }
};

class Descent {
 public:
  Descent(const LodPages& tree, const LodGain& gain, ThreadPool& pool)
      : tree_(tree), gain_(gain), pool_(pool), visits_(1) {
    visits_[0] = visit(0, 0);
  }

  LodCut run(const LodLimit& limit, float guess) {
    constexpr float kEndless = std::numeric_limits<float>::infinity();
    const std::size_t budget = std::max<std::size_t>(limit.budget, 1);
    const float round = guess > 0 ? kRoundOfGuess : kRound;
    float low = budget >= tree_.count ? limit.gain
                : guess > 0           ? std::max(limit.gain, guess / round)
                                      : kEndless;
    visits_.reserve(
        std::min<std::size_t>(tree_.count, 5 * (std::min<std::size_t>(budget, tree_.count) / 2)));
    for (float high = kEndless;;) {
      float most = open_all(low, high);  // of the gains of closed nodes
      closed_ = {.node = 0, .gain = low};
      if (count_ > budget) most = close_beyond(budget);
      if (count_ > budget || most <= limit.gain) return cut(most);
      high = low;
      low = std::max(limit.gain, most / round);
    }
  }

 private:
  // In order of (gain, node): nodes before this one are open.
  struct Place {
    std::uint32_t node = 0;
    float gain = 0;
  };

  static bool is_before(const Visit& visit, const Place& place) {
    return visit.gain != place.gain ? visit.gain > place.gain : visit.node < place.node;
  }

  Visit visit(std::uint32_t node, std::uint32_t parent) const {
    const LodPage& page = *tree_.pages[node / page_nodes_];
    const std::size_t row = node % page_nodes_;
    const LodFacts& facts = page.nodes[row];
    Visit visit{node, parent, facts.first_child, 0, facts.child_count, false};
    if (facts.child_count == 0 || (has_dead_ && has_dead_child(visit))) return visit;
    const float gain = gain_(page, row);  // NaN in a damaged file
    visit.gain = gain > kLeastGain ? std::min(gain, kMostGain) : kLeastGain;
    if (node != 0) visit.gain = std::min(visit.gain, visits_[parent].gain);
    return visit;
  }

  std::size_t first_page(const Visit& v) const { return v.first_child / page_nodes_; }
  std::size_t last_page(const Visit& v) const { return (v.first_child + v.added()) / page_nodes_; }
  bool has_dead_child(const Visit& v) const {
    return tree_.dead[first_page(v)] || tree_.dead[last_page(v)];
  }

  // Opens the closed nodes with low < gain <= high, and all nodes below them with low < gain.
  // Returns the largest gain of a node that stays closed.
  float open_all(float low, float high) {
    float most = 0;
    std::vector<std::size_t> firsts;  // by chunk of visits: the first visit of their children
    for (std::size_t begin = 0, end; begin < (end = visits_.size()); begin = end) {
      const auto is_opened = [&](const Visit& v) { return v.gain > low && v.gain <= high; };
      std::size_t next = end;
      firsts.clear();
      for (std::size_t i = begin; i < end; ++i) {
        Visit& v = visits_[i];
        if ((i - begin) % kLodGrain == 0) firsts.push_back(next);
        if (v.gain <= low) most = std::max(most, v.gain);
        if (!is_opened(v)) continue;
        count_ += v.added();
        v.is_awaited = !tree_.pages[first_page(v)] || !tree_.pages[last_page(v)];
        if (!v.is_awaited) next += v.children;
      }
      if (next > tree_.count) fail("a node of the tree is the child of several nodes");
      visits_.resize(next);
      pool_.for_chunks(end - begin, kLodGrain, [&](std::size_t first, std::size_t last, int) {
        std::size_t child = firsts[first / kLodGrain];
        for (std::size_t i = begin + first; i < begin + last; ++i) {
          const Visit& v = visits_[i];
          if (!is_opened(v) || v.is_awaited) continue;
          for (std::uint32_t k = 0; k < v.children; ++k)
            visits_[child++] = visit(v.first_child + k, static_cast<std::uint32_t>(i));
        }
      });
      high = std::numeric_limits<float>::infinity();
    }
    return most;
  }

  // Keeps the first nodes open that fit, in order of (gain, node). Returns the largest gain of the
  // others.
  float close_beyond(std::size_t budget) {
    // Gains above 0 have the order of their bits. A bin has an octave's 128th part.
    constexpr int kBinShift = 16;
    const auto bin_of = [](const Visit& v) {
      return std::bit_cast<std::uint32_t>(v.gain) >> kBinShift;
    };
    const Place all = closed_;
    std::vector<std::size_t> added(std::size_t{1} << (32 - kBinShift));
    for (const Visit& v : visits_)
      if (is_before(v, all)) added[bin_of(v)] += v.added();
    std::size_t bin = added.size() - 1, room = budget - 1;
    while (added[bin] <= room) room -= added[bin--];
    std::vector<Visit> last;
    for (const Visit& v : visits_)
      if (bin_of(v) == bin && is_before(v, all)) last.push_back(v);
    std::ranges::sort(last, [](const Visit& a, const Visit& b) {
      return is_before(a, {b.node, b.gain});
    });
    auto v = last.begin();
    for (; v->added() <= room; ++v) room -= v->added();
    closed_ = {v->node, v->gain};
    return v->gain;
  }

  LodCut cut(float limit) const {
    LodCut cut;
    cut.limit = limit;
    std::vector<LodPart> all(tree_.pages.size()), missing(tree_.pages.size());
    for (const Visit& visit : visits_) {
      const Visit& parent = visits_[visit.parent];
      if (visit.node != 0 && !is_before(parent, closed_)) continue;
      LodPart& part = all[visit.node / page_nodes_];
      const std::uint32_t row = visit.node % page_nodes_;
      part.gain = std::max(part.gain, parent.gain);
      if (part.mask.empty()) part.mask.resize((tree_.page_nodes + 63) / 64);
      const bool is_open = is_before(visit, closed_);
      if (is_open && !visit.is_awaited) continue;
      part.mask[row / 64] |= std::uint64_t{1} << row % 64;
      ++part.count;
      ++cut.count;
      if (!is_open) continue;
      for (std::size_t page = first_page(visit); page <= last_page(visit); ++page)
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
  const std::uint32_t page_nodes_ = static_cast<std::uint32_t>(tree_.page_nodes);
  const bool has_dead_ = std::ranges::find(tree_.dead, true) != tree_.dead.end();
  Array<Visit> visits_;    // parents before their children
  Place closed_;           // the first node that is not opened
  std::size_t count_ = 1;  // nodes of the cut, as if no page were missing
};

}  // namespace

std::size_t LodPage::bytes() const {
  return cloud.size() * (sizeof(glm::vec3) * 2 + sizeof(glm::quat) + sizeof(float)) +
         cloud.sh.size() * sizeof(glm::vec3) + nodes.size() * sizeof(LodFacts);
}

LodView::LodView(const Camera& of_camera, float share_outside)
    : camera(of_camera), outside(share_outside) {
  const glm::vec2 focal(camera.focal_px), middle(camera.center_px);
  const glm::vec2 size(camera.width, camera.height);
  footprint_of_depth_ = 1 / std::sqrt(focal.x * focal.y);
  near_depth_ = static_cast<float>(camera.near_depth);
  eye_ = camera.position();
  turn_ = glm::mat3(camera.view_from_world);
  for (int axis = 0; axis < 2; ++axis) {
    const auto side = [&](float pixels) {
      return glm::vec2(focal[axis], pixels) / std::hypot(focal[axis], pixels);
    };
    sides_[2 * axis] = side(size[axis] - middle[axis]);
    sides_[2 * axis + 1] = side(middle[axis] + 1);
  }
}

LodSight LodView::operator()(const glm::vec3& center, float radius) const {
  const glm::vec3 at = turn_ * glm::vec3(glm::dvec3(center) - eye_);
  // The planes of the frustum: distance of the ball's centre to each, outward.
  const auto beyond = [&](float along, const glm::vec2& side) {
    return along * side.x - at.z * side.y;
  };
  const float across = std::max(beyond(at.x, sides_[0]), beyond(-at.x, sides_[1]));
  const float down = std::max(beyond(at.y, sides_[2]), beyond(-at.y, sides_[3]));
  const float farthest = std::max(near_depth_ - at.z, std::max(across, down));
  const bool is_inside = farthest <= radius;
  const float depth = (is_inside ? at.z : glm::length(at)) - radius;
  return {std::max(depth, kSmallestDepth * near_depth_) * footprint_of_depth_,
          is_inside ? 1 : outside};
}

float lod_gain(const LodFacts& node, float smallest, float footprint) {
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
