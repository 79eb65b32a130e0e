// SPDX-License-Identifier: MIT
#include "io/scene/sog/palette.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <span>
#include <utility>

namespace qs {
namespace {

constexpr std::size_t kMostSampled = 1 << 18;  // values for a codebook
constexpr int kRounds = 8;                     // of k-means
constexpr double kWorstCells = 0.7;  // a round divides cells with this part of the largest error

// Rows that will be one vector, and where they would be divided.
struct Cell {
  std::span<std::uint32_t> members;
  double error = 0;      // sum of the squared distances to the mean; 0: cannot be divided
  std::size_t axis = 0;  // with the largest variance
  float mean = 0;        // on that axis
};

Cell measured(const VectorRows& rows, std::span<std::uint32_t> members) {
  std::vector<double> sums(rows.dimensions), squares(rows.dimensions);
  for (const std::uint32_t member : members) {
    const float* const row = rows[member];
    for (std::size_t d = 0; d < rows.dimensions; ++d) {
      const auto value = static_cast<double>(row[d]);
      sums[d] += value;
      squares[d] += value * value;
    }
  }
  Cell cell{.members = members};
  if (members.empty()) return cell;
  double largest = 0;
  for (std::size_t d = 0; d < rows.dimensions; ++d) {
    const double mean = sums[d] / static_cast<double>(members.size());
    const double error = squares[d] - sums[d] * mean;
    cell.error += std::max(error, 0.0);
    if (error <= largest) continue;
    largest = error;
    cell.axis = d;
    cell.mean = static_cast<float>(mean);
  }
  return cell;
}

// Divides the first `count` cells at their means.
void divide(const VectorRows& rows, std::size_t count, ThreadPool& pool, std::vector<Cell>& cells) {
  const std::size_t grain = count / 256 + 1;
  std::vector<Cell> above(count);
  pool.for_each(count, grain, [&](std::size_t i) {
    Cell& cell = cells[i];
    const auto end = cell.members.end();
    const auto rest = std::partition(cell.members.begin(), end, [&](std::uint32_t member) {
      return rows[member][cell.axis] <= cell.mean;
    });
    above[i].members = {rest, end};
    cell.members = {cell.members.begin(), rest};
  });
  pool.for_each(2 * count, grain, [&](std::size_t i) {
    Cell& cell = i < count ? cells[i] : above[i - count];
    cell = measured(rows, cell.members);
  });
  for (std::size_t i = 0; i < count; ++i)
    if (cells[i].members.empty() || above[i].members.empty()) {
      if (cells[i].members.empty()) cells[i] = above[i];
      cells[i].error = 0;
    } else {
      cells.push_back(above[i]);
    }
}

}  // namespace

std::uint8_t Codebook::nearest(float value) const {
  const auto* const above = std::ranges::lower_bound(values, value);
  if (above == values.begin()) return 0;
  const bool is_above = above != values.end() && *above - value < value - *(above - 1);
  return static_cast<std::uint8_t>(above - values.begin() - (is_above ? 0 : 1));
}

Codebook make_codebook(const Array<float>& values) {
  // A stride would find the same axis or channel again and again; steps of a prime find all.
  constexpr std::uint64_t kStep = 2'654'435'761;
  const auto [least, largest] = std::ranges::minmax_element(values);
  Array<float> sample = {*least, *largest};
  for (std::uint64_t i = 0; i < std::min(values.size(), kMostSampled); ++i)
    sample.push_back(values[i * kStep % values.size()]);
  std::ranges::sort(sample);
  ThreadPool alone(1);
  Codebook codebook;
  Array<float> entries =
      make_palette({sample.data(), sample.size(), 1, 1}, codebook.values.size(), alone, {}).values;
  std::ranges::sort(entries);
  codebook.values.fill(entries.back());
  std::ranges::copy(entries, codebook.values.begin());
  for (int round = 0; round < kRounds; ++round) {
    Codebook next = codebook;
    auto begin = sample.begin();
    for (std::size_t entry = 0; entry < next.values.size(); ++entry) {
      const auto end = std::ranges::partition_point(
          sample, [&](float value) { return codebook.nearest(value) <= entry; });
      if (begin != end)
        next.values[entry] =
            static_cast<float>(std::accumulate(begin, end, 0.0) / static_cast<double>(end - begin));
      begin = end;
    }
    codebook = next;
  }
  return codebook;
}

Palette make_palette(const VectorRows& rows, std::size_t most, ThreadPool& pool,
                     const Progress& progress) {
  std::vector<std::uint32_t> members(rows.count);
  std::iota(members.begin(), members.end(), 0u);
  std::vector<Cell> cells = {measured(rows, members)};
  while (cells.size() < most) {
    progress.update(static_cast<float>(cells.size()) / static_cast<float>(most));
    const double largest = std::ranges::max(cells, {}, &Cell::error).error;
    if (largest == 0) break;
    const auto others = std::partition(cells.begin(), cells.end(), [&](const Cell& cell) {
      return cell.error >= kWorstCells * largest;
    });
    const auto worst = static_cast<std::size_t>(others - cells.begin());
    const std::size_t count = std::min(worst, most - cells.size());
    std::ranges::nth_element(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(count),
                             others, std::greater(), &Cell::error);
    divide(rows, count, pool, cells);
  }
  // Frequent labels are small numbers, so their picture has fewer bytes.
  std::ranges::sort(cells, std::greater(), [](const Cell& cell) {
    return std::pair(cell.members.size(), cell.members.data());
  });
  Palette palette{rows.dimensions, Array<float>(cells.size() * rows.dimensions),
                  std::vector<std::uint32_t>(rows.count)};
  pool.for_each(cells.size(), cells.size() / 256 + 1, [&](std::size_t i) {
    std::vector<double> sums(rows.dimensions);
    for (const std::uint32_t member : cells[i].members) {
      palette.label[member] = static_cast<std::uint32_t>(i);
      for (std::size_t d = 0; d < rows.dimensions; ++d)
        sums[d] += static_cast<double>(rows[member][d]);
    }
    const auto count = static_cast<double>(cells[i].members.size());
    std::ranges::transform(sums, &palette.values[i * rows.dimensions],
                           [&](double sum) { return static_cast<float>(sum / count); });
  });
  return palette;
}

}  // namespace qs
