// SPDX-License-Identifier: MIT
#include "io/scene/sog/palette.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <random>
#include <span>
#include <utility>

namespace qs {
namespace {

// ---- codebooks ----------------------------------------------------------------------------------

constexpr std::size_t kMostSorted = 1 << 22;

// Sorted values with sums, so that the mean and the squared error of a range cost nothing.
class SortedValues {
 public:
  explicit SortedValues(std::vector<float> values) : values_(std::move(values)) {
    std::ranges::sort(values_);
    sums_.reserve(values_.size() + 1);
    squares_.reserve(values_.size() + 1);
    for (double sum = 0, square = 0; const float value : values_) {
      sums_.push_back(sum += static_cast<double>(value));
      squares_.push_back(square += static_cast<double>(value) * static_cast<double>(value));
    }
  }

  std::size_t size() const { return values_.size(); }
  double mean(std::size_t begin, std::size_t end) const {
    if (values_[begin] == values_[end - 1]) return static_cast<double>(values_[begin]);  // exact
    return (sums_[end] - sums_[begin]) / static_cast<double>(end - begin);
  }
  double error(std::size_t begin, std::size_t end) const {
    if (values_[begin] == values_[end - 1]) return 0;
    const double sum = sums_[end] - sums_[begin];
    return squares_[end] - squares_[begin] - sum * sum / static_cast<double>(end - begin);
  }
  /// The first value above `bound` in [begin, end).
  std::size_t above(double bound, std::size_t begin, std::size_t end) const {
    const auto at = values_.begin();
    return static_cast<std::size_t>(
        std::upper_bound(at + static_cast<std::ptrdiff_t>(begin),
                         at + static_cast<std::ptrdiff_t>(end), bound,
                         [](double b, float v) { return b < static_cast<double>(v); }) -
        at);
  }

 private:
  std::vector<float> values_;
  std::vector<double> sums_{0}, squares_{0};
};

// The means of at most `most` ranges: the range with the largest error is split at its mean until
// there are enough.
std::vector<double> split_means(const SortedValues& values, std::size_t most) {
  struct Range {
    double error;
    std::size_t begin, end;
    bool operator<(const Range& other) const { return error < other.error; }
  };
  std::priority_queue<Range> ranges;
  ranges.push({values.error(0, values.size()), 0, values.size()});
  std::vector<double> means;
  while (!ranges.empty()) {
    const Range range = ranges.top();
    ranges.pop();
    const double mean = values.mean(range.begin, range.end);
    const std::size_t middle = values.above(mean, range.begin, range.end);
    const bool is_split = range.error > 0 && middle < range.end && middle > range.begin &&
                          means.size() + ranges.size() + 2 <= most;
    if (!is_split) {
      means.push_back(mean);
      continue;
    }
    ranges.push({values.error(range.begin, middle), range.begin, middle});
    ranges.push({values.error(middle, range.end), middle, range.end});
  }
  std::ranges::sort(means);
  return means;
}

// One step of k-means: each mean moves to the mean of the values that are nearest to it.
void move_means(const SortedValues& values, std::vector<double>& means) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const std::size_t end = i + 1 == means.size()
                                ? values.size()
                                : values.above((means[i] + means[i + 1]) / 2, begin, values.size());
    if (end > begin) means[i] = values.mean(begin, end);
    begin = end;
  }
}

// ---- palettes -----------------------------------------------------------------------------------

constexpr std::size_t kMostGroups = 256;   // of a node of the tree
constexpr std::size_t kRowsPerGroup = 64;  // that k-means looks at
constexpr int kRounds = 6;

// Vectors, arranged so that the distances of a row to 16 of them are computed together.
class Centres {
 public:
  Centres(std::size_t count, std::size_t dimensions)
      : count_(count), dimensions_(dimensions), blocks_((count + kBlock - 1) / kBlock) {
    values_.resize(blocks_ * dimensions * kBlock);
    half_squares_.resize(blocks_ * kBlock, std::numeric_limits<float>::infinity());
  }

  std::size_t size() const { return count_; }

  template <class T>
  void set(std::size_t i, const T* row, double factor) {
    float* const column = &values_[i / kBlock * dimensions_ * kBlock + i % kBlock];
    float square = 0;
    for (std::size_t d = 0; d < dimensions_; ++d) {
      const auto value = static_cast<float>(static_cast<double>(row[d]) * factor);
      column[d * kBlock] = value;
      square += value * value;
    }
    half_squares_[i] = square / 2;
  }

  /// |row - centre|^2 / 2 is |row|^2 / 2 plus the value that is compared here.
  std::size_t nearest(const float* row) const {
    std::size_t best = 0;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t block = 0; block < blocks_; ++block) {
      std::array<float, kBlock> distances;
      std::copy_n(&half_squares_[block * kBlock], kBlock, distances.begin());
      const float* column = &values_[block * dimensions_ * kBlock];
      for (std::size_t d = 0; d < dimensions_; ++d, column += kBlock)
        for (std::size_t j = 0; j < kBlock; ++j) distances[j] -= row[d] * column[j];
      for (std::size_t j = 0; j < kBlock; ++j) {
        if (!(distances[j] < least)) continue;
        least = distances[j];
        best = block * kBlock + j;
      }
    }
    return best;
  }

 private:
  static constexpr std::size_t kBlock = 16;
  std::size_t count_, dimensions_, blocks_;
  std::vector<float> values_;  // zeros beside the last centre
  std::vector<float> half_squares_;
};

using Members = std::span<std::uint32_t>;  // indices of rows

class PaletteTree {
 public:
  PaletteTree(const VectorRows& rows, std::size_t most, Palette& palette)
      : rows_(rows), palette_(palette), used_(most) {
    palette.values.resize(most * rows.dimensions);
  }

  void build(std::size_t most, ThreadPool& pool, const Progress& progress) {
    std::vector<std::uint32_t> members(rows_.count);
    std::iota(members.begin(), members.end(), 0u);
    const std::vector<Group> groups = divide(members, 0, most, &pool);
    std::vector<std::size_t> order(groups.size());  // large groups take longest and start first
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, std::greater(),
                             [&](std::size_t i) { return groups[i].members.size(); });
    pool.for_chunks(groups.size(), 1, [&](std::size_t begin, std::size_t, int worker) {
      if (worker == 0)
        progress.update(static_cast<float>(begin) / static_cast<float>(groups.size()));
      fill(groups[order[begin]]);
    });
    remove_unused();
  }

 private:
  struct Group {
    Members members;
    std::size_t first, entries;  // of the palette
  };

  void fill(const Group& group) {
    if (group.entries <= kMostGroups) return finish(group);
    const std::vector<Group> parts = divide(group.members, group.first, group.entries, nullptr);
    // Equal rows cannot be divided.
    if (parts.size() == 1) return finish({group.members, group.first, 1});
    for (const Group& part : parts) fill(part);
  }

  Centres k_means(Members members, std::size_t count) const {
    Centres centres(count, rows_.dimensions);
    std::minstd_rand random;  // one member of each of `count` equal ranges
    for (std::size_t j = 0; j < count; ++j) {
      const std::size_t begin = j * members.size() / count;
      const std::size_t end = (j + 1) * members.size() / count;
      centres.set(j, rows_[members[begin + random() % (end - begin)]], 1);
    }
    const std::size_t step = std::max<std::size_t>(1, members.size() / (count * kRowsPerGroup));
    std::vector<double> sums;
    std::vector<std::size_t> counts;
    for (int round = 0; round < kRounds; ++round) {
      sums.assign(count * rows_.dimensions, 0);
      counts.assign(count, 0);
      for (std::size_t i = 0; i < members.size(); i += step) {
        const float* const row = rows_[members[i]];
        add(centres.nearest(row), row, sums, counts);
      }
      set_means(sums, counts, centres);
    }
    return centres;
  }

  void add(std::size_t j, const float* row, std::vector<double>& sums,
           std::vector<std::size_t>& counts) const {
    ++counts[j];
    double* const sum = &sums[j * rows_.dimensions];
    for (std::size_t d = 0; d < rows_.dimensions; ++d) sum[d] += static_cast<double>(row[d]);
  }

  // A centre without rows stays where it is.
  void set_means(const std::vector<double>& sums, const std::vector<std::size_t>& counts,
                 Centres& centres) const {
    for (std::size_t j = 0; j < counts.size(); ++j)
      if (counts[j] > 0)
        centres.set(j, &sums[j * rows_.dimensions], 1 / static_cast<double>(counts[j]));
  }

  // Sorts the members by group. `pool` is null within a loop of the pool.
  std::vector<Group> divide(Members members, std::size_t first, std::size_t entries,
                            ThreadPool* pool) {
    const Centres centres = k_means(members, std::min({kMostGroups, entries, members.size()}));
    std::vector<std::uint16_t> labels(members.size());
    const auto label = [&](std::size_t i) {
      labels[i] = static_cast<std::uint16_t>(centres.nearest(rows_[members[i]]));
    };
    constexpr std::size_t kGrain = 4096;
    if (pool != nullptr) pool->for_each(members.size(), kGrain, label);
    if (pool == nullptr)
      for (std::size_t i = 0; i < members.size(); ++i) label(i);

    std::vector<std::size_t> ends(centres.size() + 1);
    for (const std::uint16_t j : labels) ++ends[j + std::size_t{1}];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<std::uint32_t> sorted(members.size());
    std::vector<std::size_t> next(ends.begin(), ends.end() - 1);
    for (std::size_t i = 0; i < members.size(); ++i) sorted[next[labels[i]]++] = members[i];
    std::ranges::copy(sorted, members.begin());

    std::vector<Group> groups;
    std::vector<double> errors;
    for (std::size_t j = 0; j < centres.size(); ++j) {
      const Members part = members.subspan(ends[j], ends[j + 1] - ends[j]);
      if (part.empty()) continue;
      groups.push_back({part, 0, 1});
      errors.push_back(error_of(part));
    }
    share(entries, errors, groups);
    for (Group& group : groups) {
      group.first = first;
      first += group.entries;
    }
    return groups;
  }

  // The sum of the squared distances to the mean.
  double error_of(Members members) const {
    double error = 0;
    for (std::size_t d = 0; d < rows_.dimensions; ++d) {
      double sum = 0, square = 0;
      for (const std::uint32_t member : members) {
        const auto value = static_cast<double>(rows_[member][d]);
        sum += value;
        square += value * value;
      }
      error += std::max(0.0, square - sum * sum / static_cast<double>(members.size()));
    }
    return error;
  }

  // Every group has an entry; the others are shared in proportion to the errors, and no group gets
  // more entries than members.
  static void share(std::size_t entries, std::span<const double> errors, std::span<Group> groups) {
    constexpr int kShares = 4;
    for (int round = 0; round < kShares; ++round) {
      std::size_t given = 0;
      double open = 0;  // error of groups that may get more
      for (std::size_t i = 0; i < groups.size(); ++i) {
        given += groups[i].entries;
        if (groups[i].entries < groups[i].members.size()) open += errors[i];
      }
      if (given >= entries || !(open > 0)) return;
      const auto left = static_cast<double>(entries - given);
      for (std::size_t i = 0; i < groups.size(); ++i) {
        const std::size_t most = groups[i].members.size();
        if (groups[i].entries >= most) continue;
        const auto more = static_cast<std::size_t>(left * errors[i] / open);
        groups[i].entries = std::min(most, groups[i].entries + more);
      }
    }
  }

  // A leaf: its entries are means of its members.
  void finish(const Group& group) {
    const std::size_t count = std::min(group.entries, group.members.size());
    const Centres centres = k_means(group.members, count);
    std::vector<double> sums(count * rows_.dimensions);
    std::vector<std::size_t> counts(count);
    for (const std::uint32_t member : group.members) {
      const std::size_t j = centres.nearest(rows_[member]);
      palette_.label[member] = static_cast<std::uint32_t>(group.first + j);
      add(j, rows_[member], sums, counts);
    }
    for (std::size_t j = 0; j < count; ++j) {
      if (counts[j] == 0) continue;
      used_[group.first + j] = 1;
      for (std::size_t d = 0; d < rows_.dimensions; ++d)
        palette_.values[(group.first + j) * rows_.dimensions + d] =
            static_cast<float>(sums[j * rows_.dimensions + d] / static_cast<double>(counts[j]));
    }
  }

  void remove_unused() {
    std::vector<std::uint32_t> number(used_.size());
    std::uint32_t kept = 0;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      number[i] = kept;
      if (used_[i] == 0) continue;
      std::copy_n(&palette_.values[i * rows_.dimensions], rows_.dimensions,
                  &palette_.values[kept++ * rows_.dimensions]);
    }
    palette_.values.resize(kept * rows_.dimensions);
    for (std::uint32_t& label : palette_.label) label = number[label];
  }

  const VectorRows& rows_;
  Palette& palette_;
  std::vector<char> used_;  // not bool: threads write neighbours
};

}  // namespace

std::uint8_t Codebook::nearest(float value) const {
  const auto* const above = std::ranges::lower_bound(values, value);
  if (above == values.begin()) return 0;
  const bool is_above = above != values.end() && *above - value < value - *(above - 1);
  return static_cast<std::uint8_t>(above - values.begin() - (is_above ? 0 : 1));
}

Codebook make_codebook(const Array<float>& values) {
  constexpr int kCodebookRounds = 32;
  const std::size_t step = (values.size() + kMostSorted - 1) / kMostSorted;
  std::vector<float> sample;
  for (std::size_t i = 0; i < values.size(); i += step) sample.push_back(values[i]);
  const auto [least, largest] = std::ranges::minmax_element(values);
  sample.insert(sample.end(), {*least, *largest});
  const SortedValues sorted(std::move(sample));
  Codebook codebook;
  std::vector<double> means = split_means(sorted, codebook.values.size());
  for (int round = 0; round < kCodebookRounds; ++round) move_means(sorted, means);
  means.resize(codebook.values.size(), means.back());
  std::ranges::transform(means, codebook.values.begin(),
                         [](double mean) { return static_cast<float>(mean); });
  return codebook;
}

Palette make_palette(const VectorRows& rows, std::size_t most, ThreadPool& pool,
                     const Progress& progress) {
  Palette palette;
  palette.dimensions = rows.dimensions;
  palette.label.resize(rows.count);
  if (rows.count > most) {
    PaletteTree(rows, most, palette).build(most, pool, progress);
    return palette;
  }
  std::iota(palette.label.begin(), palette.label.end(), 0u);
  for (std::size_t i = 0; i < rows.count; ++i)
    palette.values.insert(palette.values.end(), rows[i], rows[i] + rows.dimensions);
  return palette;
}

}  // namespace qs
