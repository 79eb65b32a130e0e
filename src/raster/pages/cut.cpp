// SPDX-License-Identifier: MIT
#include "raster/pages/cut.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "base/fail.h"
#include "raster/kernel/blend.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

constexpr float kSmallestDepth = 1e-3f;  // of a ball around a camera, in depths of its near plane
constexpr float kLeastGain = std::numeric_limits<float>::min();  // of merged nodes
constexpr float kEndless = std::numeric_limits<float>::infinity();
constexpr float kMostGain = std::numeric_limits<float>::max();
constexpr float kRound = 4;  // a round opens the nodes down to this part of the largest gain
constexpr float kRoundOfGuess = 1.2f;  // the same below a guess
constexpr float kMostRound = 1e9f;
constexpr std::size_t kLodGrain = 512;
constexpr std::size_t kAhead = 16;          // visits
constexpr std::size_t kLeastRange = 65536;  // visits

// log2 of a normal number above 0, error below 2e-7 of its size plus 1.
float log2_of(float x) {
  // x = m * 2^e with m in [sqrt(1/2), sqrt(2)).
  constexpr std::uint32_t kRootOfHalf = 0x3f3504f3;
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const auto exponent = static_cast<std::int32_t>(bits - kRootOfHalf) >> 23;
  const auto m = std::bit_cast<float>(bits - (static_cast<std::uint32_t>(exponent) << 23));
  // ln m = 2 atanh(t), t = (m - 1) / (m + 1).
  const float t = (m - 1) / (m + 1), tt = t * t;
  const float series = 1 + tt * (1.0f / 3 + tt * (1.0f / 5 + tt * (1.0f / 7)));
  return static_cast<float>(exponent) + 2 * static_cast<float>(kLog2E) * t * series;
}

// The footprint so many times the smallest one, as a place among the kLodFootprints of a node.
float place_of(float ratio) {
  constexpr float kLog2OfRatio = 2;
  static_assert(kLodFootprintRatio == 4);
  return std::min(std::max(log2_of(ratio) / kLog2OfRatio, 0.0f),
                  static_cast<float>(kLodFootprints - 1));
}

float value_of_step(float step) { return exp2_polynomial(step / 4 - 28); }

class Descent {
 public:
  Descent(const LodPages& tree, const LodGain& gain, ThreadPool& pool, Array<LodVisit>& visits)
      : tree_(tree), gain_(gain), pool_(pool), visits_(visits) {
    visits_.resize(1);
    for (const auto& page : tree.pages) {
      pages_.push_back(page.get());
      in_memory_ += page ? page->nodes.size() : 0;
    }
    Batch batch(*this);
    batch.visit(0, 0, 0, 0, 0);
  }

  LodCut run(const LodLimit& limit, float guess) {
    const std::size_t budget = std::max<std::size_t>(limit.budget, 1);
    float round = guess > 0 ? kRoundOfGuess : kRound;
    float low = budget >= tree_.count ? limit.gain
                : guess > 0           ? std::max(limit.gain, guess / round)
                                      : kEndless;
    visits_.reserve(std::min(in_memory_, 5 * (std::min<std::size_t>(budget, tree_.count) / 2)));
    for (float high = kEndless;;) {
      const std::size_t before = count_;
      float most = open_all(low, high);  // of the gains of closed nodes
      closed_ = {.node = 0, .gain = low};
      if (count_ > budget) most = close_beyond(budget);
      if (count_ > budget || most <= limit.gain) return cut(most);
      // Most leaves of a tree may have far smaller gains than its merged nodes.
      if (count_ - before < before / 8) round = std::min(round * round, kMostRound);
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

  static bool is_before(const LodVisit& visit, const Place& place) {
    return visit.gain != place.gain ? visit.gain > place.gain : visit.node < place.node;
  }

  // Fills visits, and asks for the gains of many at a time.
  class Batch {
   public:
    explicit Batch(Descent& descent) : descent_(descent) {}
    ~Batch() { ask(); }

    void visit(std::size_t i, std::size_t page, std::uint32_t row, std::uint32_t node,
               std::uint32_t parent) {
      const LodFacts& facts = descent_.pages_[page]->nodes[row];
      const LodPlacement* const placement = descent_.tree_.placement(page);
      const std::uint32_t first_child = facts.first_child + (placement ? placement->base : 0);
      LodVisit& visit = descent_.visits_[i];
      // The root has no parent that limits its gain.
      const float parent_gain = node == 0 ? kEndless : descent_.visits_[parent].gain;
      visit = {node, parent, first_child, 0, parent_gain, facts.child_count, false};
      if (facts.child_count == 0 || (descent_.has_dead_ && descent_.has_dead_child(visit))) return;
      asked_[count_] = {descent_.pages_[page], placement, row, 0};
      visits_[count_] = static_cast<std::uint32_t>(i);
      if (++count_ == kLodBatch) ask();
    }

   private:
    void ask() {
      descent_.gain_(std::span(asked_).first(count_));
      for (std::size_t k = 0; k < count_; ++k) {
        LodVisit& visit = descent_.visits_[visits_[k]];
        const float gain = asked_[k].gain;  // NaN in a damaged file
        visit.gain =
            gain > kLeastGain ? std::min({gain, visit.parent_gain, kMostGain}) : kLeastGain;
      }
      count_ = 0;
    }

    Descent& descent_;
    std::size_t count_ = 0;
    std::array<LodAsked, kLodBatch> asked_;
    std::array<std::uint32_t, kLodBatch> visits_;
  };

  std::size_t page_of(std::uint32_t node) const {
    return shift_ > 0 ? node >> shift_ : node / page_nodes_;
  }
  std::size_t first_page(const LodVisit& v) const { return page_of(v.first_child); }
  std::size_t last_page(const LodVisit& v) const { return page_of(v.first_child + v.added()); }
  bool has_dead_child(const LodVisit& v) const {
    return tree_.dead[first_page(v)] || tree_.dead[last_page(v)];
  }

  // Without this, the way down mostly waits for memory.
  void prefetch_children(const LodVisit& v) const {
    const std::size_t page = first_page(v);
    const std::uint32_t row = v.first_child - static_cast<std::uint32_t>(page) * page_nodes_;
    const char* const facts = reinterpret_cast<const char*>(&pages_[page]->nodes[row]);
    __builtin_prefetch(facts);
    __builtin_prefetch(facts + 64);
    if (row < pages_[page]->cloud.positions.size())
      __builtin_prefetch(&pages_[page]->cloud.positions[row]);
  }

  // Opens the closed nodes with low < gain <= high, and all nodes below them with low < gain.
  // Returns the largest gain of a node that stays closed.
  float open_all(float low, float high) {
    float most = 0;
    std::vector<std::size_t>
        firsts;                   // by chunk of opened visits: the first visit of their children
    Array<std::uint32_t> opened;  // visits whose children come next
    for (std::size_t begin = 0, end; begin < (end = visits_.size()); begin = end) {
      opened.resize(end - begin);
      std::size_t count = 0;
      for (std::size_t i = begin; i < end; ++i) {  // no branches: they would be mispredicted
        const float gain = visits_[i].gain;
        most = std::max(most, gain <= low ? gain : 0.0f);
        opened[count] = static_cast<std::uint32_t>(i);
        count += static_cast<std::size_t>(gain > low) & static_cast<std::size_t>(gain <= high);
      }
      opened.resize(count);
      std::size_t next = end, here = 0;
      firsts.clear();
      for (const std::uint32_t i : opened) {
        LodVisit& v = visits_[i];
        count_ += v.added();
        v.is_awaited = !pages_[first_page(v)] || !pages_[last_page(v)];
        if (v.is_awaited) continue;
        if (here % kLodGrain == 0) firsts.push_back(next);
        opened[here++] = i;
        next += v.children;
      }
      opened.resize(here);
      if (next > tree_.count) fail("a node of the tree is the child of several nodes");
      visits_.resize(next);
      pool_.for_chunks(here, kLodGrain, [&](std::size_t first, std::size_t last, int) {
        Batch batch(*this);
        std::size_t child = firsts[first / kLodGrain];
        for (std::size_t k = first; k < last; ++k) {
          prefetch_children(visits_[opened[std::min(k + kAhead, last - 1)]]);
          const LodVisit& v = visits_[opened[k]];
          std::size_t page = first_page(v);
          std::uint32_t row = v.first_child - static_cast<std::uint32_t>(page) * page_nodes_;
          for (std::uint32_t c = 0; c < v.children; ++c, ++row) {
            if (row == page_nodes_) {
              ++page;
              row = 0;
            }
            batch.visit(child++, page, row, v.first_child + c, opened[k]);
          }
        }
      });
      high = kEndless;
    }
    return most;
  }

  // Keeps the first nodes open that fit, in order of (gain, node). Returns the largest gain of the
  // others.
  float close_beyond(std::size_t budget) {
    // Gains above 0 have the order of their bits. A bin has an octave's 128th part.
    constexpr int kBinShift = 16;
    const auto bin_of = [](const LodVisit& v) {
      return std::bit_cast<std::uint32_t>(v.gain) >> kBinShift;
    };
    const Place all = closed_;
    std::vector<std::vector<std::size_t>> added(ranges());
    for_ranges([&](std::size_t range, std::size_t begin, std::size_t end) {
      std::vector<std::size_t> own(std::size_t{1} << (32 - kBinShift));
      for (std::size_t i = begin; i < end; ++i)
        if (is_before(visits_[i], all)) own[bin_of(visits_[i])] += visits_[i].added();
      added[range] = std::move(own);
    });
    const auto added_in = [&](std::size_t bin) {
      std::size_t sum = 0;
      for (const std::vector<std::size_t>& own : added) sum += own[bin];
      return sum;
    };
    std::size_t bin = added[0].size() - 1, room = budget - 1;
    for (std::size_t sum; (sum = added_in(bin)) <= room; --bin) room -= sum;
    std::vector<std::vector<LodVisit>> lasts(ranges());
    for_ranges([&](std::size_t range, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        if (bin_of(visits_[i]) == bin && is_before(visits_[i], all))
          lasts[range].push_back(visits_[i]);
    });
    std::vector<LodVisit> last;
    for (const std::vector<LodVisit>& own : lasts) last.insert(last.end(), own.begin(), own.end());
    std::ranges::sort(last, [](const LodVisit& a, const LodVisit& b) {
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
    struct Drawn {
      std::vector<LodPart> parts;
      std::vector<const LodVisit*> awaited;
    };
    std::vector<Drawn> drawn(ranges());
    for_ranges([&](std::size_t range, std::size_t begin, std::size_t end) {
      drawn[range].parts.resize(pages_.size());
      for (std::size_t i = begin; i < end; ++i) draw(visits_[i], drawn[range]);
    });
    std::vector<LodPart>& all = drawn[0].parts;
    pool_.for_each(all.size(), 16, [&](std::size_t page) {
      for (std::size_t range = 1; range < drawn.size(); ++range)
        join(all[page], drawn[range].parts[page]);
    });
    std::vector<LodPart> missing(pages_.size());
    for (const Drawn& own : drawn)
      for (const LodVisit* visit : own.awaited)
        for (std::size_t page = first_page(*visit); page <= last_page(*visit); ++page)
          if (!pages_[page]) missing[page].gain += visit->gain;
    for (std::uint32_t page = 0; page < all.size(); ++page) {
      all[page].page = missing[page].page = page;
      cut.count += all[page].count;
      if (all[page].mask.size() > 0) cut.parts.push_back(std::move(all[page]));
      if (missing[page].gain > 0) cut.missing.push_back(std::move(missing[page]));
    }
    std::ranges::stable_sort(cut.missing, std::ranges::greater(), &LodPart::gain);
    return cut;
  }

  void draw(const LodVisit& visit, auto& drawn) const {
    if (visit.node != 0 &&
        (visit.parent_gain < closed_.gain ||
         (visit.parent_gain == closed_.gain && !is_before(visits_[visit.parent], closed_))))
      return;
    const std::size_t page = page_of(visit.node);
    LodPart& part = drawn.parts[page];
    const std::uint32_t row = visit.node - static_cast<std::uint32_t>(page) * page_nodes_;
    part.gain = std::max(part.gain, visit.parent_gain);
    if (part.mask.size() == 0) part.mask = GaussianSet(tree_.page_nodes);
    const bool is_open = is_before(visit, closed_);
    if (is_open && !visit.is_awaited) return;
    part.mask.add(row);
    ++part.count;
    if (is_open) drawn.awaited.push_back(&visit);
  }

  static void join(LodPart& part, LodPart& other) {
    if (part.mask.size() == 0) return std::swap(part, other);
    if (other.mask.size() == 0) return;
    part.gain = std::max(part.gain, other.gain);
    part.count += other.count;
    part.mask |= other.mask;
  }

  // The visits in ranges, one for each thread.
  std::size_t range_size() const {
    const auto threads = static_cast<std::size_t>(pool_.size());
    return std::max<std::size_t>(kLeastRange, (visits_.size() + threads - 1) / threads);
  }
  std::size_t ranges() const { return (visits_.size() + range_size() - 1) / range_size(); }
  void for_ranges(const auto& each) const {
    const std::size_t size = range_size();
    pool_.for_chunks(visits_.size(), size, [&](std::size_t begin, std::size_t end, int) {
      each(begin / size, begin, end);
    });
  }

  const LodPages& tree_;
  const LodGain& gain_;
  ThreadPool& pool_;
  const std::uint32_t page_nodes_ = static_cast<std::uint32_t>(tree_.page_nodes);
  const int shift_ = std::has_single_bit(page_nodes_) ? std::countr_zero(page_nodes_) : 0;
  std::size_t in_memory_ = 0;  // nodes
  std::vector<const LodPage*> pages_;
  const bool has_dead_ = std::ranges::find(tree_.dead, true) != tree_.dead.end();
  Array<LodVisit>& visits_;  // parents before their children
  Place closed_;             // the first node that is not opened
  std::size_t count_ = 1;    // nodes of the cut, as if no page were missing
};

}  // namespace

std::size_t LodPage::bytes() const {
  const std::size_t each = sizeof(LodFacts) + (as_read ? sizeof(LodFacts) + sizeof(float) : 0);
  return cloud.size() * (sizeof(glm::vec3) * 2 + sizeof(glm::quat) + sizeof(float)) +
         cloud.sh.size() * sizeof(glm::vec3) + nodes.size() * each +
         numbers.size() * sizeof(std::uint32_t) + selected.memory();
}

std::pair<glm::vec3, float> lod_ball(const LodPage& page, std::size_t row,
                                     const LodPlacement* placement) {
  const glm::vec3& center = page.cloud.positions[row];
  const float radius = page.nodes[row].radius;
  if (!placement) return {center, radius};
  return {placement->at(center), placement->scale * radius};
}

LodView::LodView(const Camera& of_camera, float share_outside, const LodReach& of_lens)
    : camera(of_camera), outside(share_outside), reach(of_lens) {
  const glm::vec2 focal(camera.focal_px), middle(camera.center_px);
  const glm::vec2 size(camera.width, camera.height);
  const bool is_parallel = camera.projection == Projection::orthographic;
  const float footprint = 1 / std::sqrt(focal.x * focal.y);
  footprint_of_depth_ = is_parallel ? 0 : footprint;
  footprint_ = is_parallel ? footprint : 0;
  near_depth_ = static_cast<float>(camera.near_depth);
  eye_ = camera.position();
  turn_ = glm::mat3(camera.view_from_world);
  for (int axis = 0; axis < 2; ++axis) {
    const auto side = [&](float pixels) {
      if (is_parallel) return glm::vec3(1, 0, pixels / focal[axis]);
      return glm::vec3(focal[axis], pixels, 0) / std::hypot(focal[axis], pixels);
    };
    sides_[2 * axis] = side(size[axis] - middle[axis]);
    sides_[2 * axis + 1] = side(middle[axis] + 1);
  }
  if (reach.angle > 0) sides_[0] = glm::vec3(std::cos(reach.angle), std::sin(reach.angle), 0);
}

LodSight LodView::operator()(const glm::vec3& center, float radius) const {
  LodSight sight;
  see(1, &center.x, &center.y, &center.z, &radius, &sight.footprint, &sight.share);
  return sight;
}

void LodView::see(std::size_t count, const float* x, const float* y, const float* z,
                  const float* radius, float* footprint, float* share) const {
  const glm::mat3& m = turn_;
  const bool is_wide = reach.angle > 0;
  const auto eye = static_cast<float>(reach.eye);
  for (std::size_t k = 0; k < count; ++k) {
    const auto dx = static_cast<float>(x[k] - eye_.x), dy = static_cast<float>(y[k] - eye_.y),
               dz = static_cast<float>(z[k] - eye_.z);
    const glm::vec3 at(m[0].x * dx + m[1].x * dy + m[2].x * dz,
                       m[0].y * dx + m[1].y * dy + m[2].y * dz,
                       m[0].z * dx + m[1].z * dy + m[2].z * dz);
    // The planes of the frustum: distance of the ball's centre to each, outward.
    const auto beyond = [&](float along, const glm::vec3& side) {
      return along * side.x - at.z * side.y - side.z;
    };
    const float across = std::max(beyond(at.x, sides_[0]), beyond(-at.x, sides_[1]));
    const float down = std::max(beyond(at.y, sides_[2]), beyond(-at.y, sides_[3]));
    const float from_axis = at.x * at.x + at.y * at.y;
    const float farthest = is_wide ? beyond(std::sqrt(from_axis), sides_[0]) - eye
                                   : std::max(near_depth_ - at.z, std::max(across, down));
    const bool is_inside = farthest <= radius[k];
    const float distance = std::sqrt(from_axis + at.z * at.z);
    const float depth = (is_inside && !is_wide ? at.z : distance) - radius[k] - eye;
    footprint[k] = std::max(depth, kSmallestDepth * near_depth_) * footprint_of_depth_ + footprint_;
    share[k] = is_inside ? 1.0f : outside;
  }
  for (std::size_t k = 0; k < count && surfaces; ++k)
    if (share[k] == 1)
      share[k] = std::max(outside, surfaces->share_seen({x[k], y[k], z[k]}, radius[k]));
}

LodView even_view(float footprint) {
  Camera camera;
  camera.focal_px = glm::dvec2(1 / footprint);
  camera.projection = Projection::orthographic;
  return {camera, 1};
}

float lod_gain(const LodFacts& node, float smallest, float footprint) {
  if (node.child_count == 0) return 0;
  return smallest * smallest *
         value_of_step(lod_step_at(node.gains, place_of(footprint / smallest))) /
         (footprint * footprint);
}

void open_first(LodFacts& node, float smallest) {
  for (std::size_t k = 0; k < kLodFootprints && node.radius > lod_footprint(smallest, k); ++k)
    node.gains[k] = kLodMostSteps;
}

LodGain gain_in(const LodView& view, float smallest) {
  return LodGain([=](std::span<LodAsked> nodes) {
    // A loop for each part of the work, so that the compiler makes vectors.
    using Values = std::array<float, kLodBatch>;
    Values x{}, y{}, z{}, radius{}, footprint{}, share{}, value{};
    const std::size_t count = nodes.size();
    for (std::size_t k = 0; k < count; ++k) {
      const auto [center, size] = lod_ball(*nodes[k].page, nodes[k].row, nodes[k].placement);
      x[k] = center.x, y[k] = center.y, z[k] = center.z;
      radius[k] = size;
    }
    view.see(count, x.data(), y.data(), z.data(), radius.data(), footprint.data(), share.data());
    // Gains are areas: an instance has the gain of its tree at the footprint in its units.
    for (std::size_t k = 0; k < count; ++k)
      if (nodes[k].placement) footprint[k] /= nodes[k].placement->scale;
    if (smallest > 0) {
      const float squared = smallest * smallest, inverse = 1 / smallest;
      for (std::size_t k = 0; k < count; ++k) value[k] = place_of(footprint[k] * inverse);
      for (std::size_t k = 0; k < count; ++k)
        value[k] = lod_step_at(nodes[k].page->nodes[nodes[k].row].gains, value[k]);
      for (std::size_t k = 0; k < count; ++k)
        value[k] = share[k] * squared * value_of_step(value[k]) / (footprint[k] * footprint[k]);
    } else {
      for (std::size_t k = 0; k < count; ++k)
        value[k] = share[k] * radius[k] * radius[k] / (footprint[k] * footprint[k]);
    }
    for (std::size_t k = 0; k < count; ++k) nodes[k].gain = value[k];
  });
}

LodGain gain_in(std::span<const LodView> views, float smallest) {
  std::vector<LodGain> gains;
  for (const LodView& view : views) gains.push_back(gain_in(view, smallest));
  return LodGain([gains = std::move(gains)](std::span<LodAsked> nodes) {
    std::vector<float> sums(nodes.size());
    for (const LodGain& gain : gains) {
      gain(nodes);
      for (std::size_t k = 0; k < nodes.size(); ++k) sums[k] += nodes[k].gain;
    }
    for (std::size_t k = 0; k < nodes.size(); ++k) nodes[k].gain = sums[k];
  });
}

LodCut cut_of(const LodPages& tree, const LodGain& gain, const LodLimit& limit, ThreadPool& pool,
              float guess, Array<LodVisit>* kept) {
  Array<LodVisit> own;
  return Descent(tree, gain, pool, kept ? *kept : own).run(limit, guess);
}

}  // namespace qs
