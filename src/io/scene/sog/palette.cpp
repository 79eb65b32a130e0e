// SPDX-License-Identifier: MIT
#include "io/scene/sog/palette.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <span>

namespace qs {
namespace {

constexpr std::size_t kMostSampled = 1 << 20;  // values for a codebook
constexpr int kRounds = 8;                     // of k-means

// Rows that will be one vector, and where they would be divided.
struct Cell {
  double error = 0;  // sum of the squared distances to the mean
  std::span<std::uint32_t> members;
  std::size_t axis = 0;  // with the largest variance
  float mean = 0;        // on that axis

  bool operator<(const Cell& other) const { return error < other.error; }
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

// The cells' means, and the cell of each row.
void finish(const VectorRows& rows, std::span<const Cell> cells, Palette& palette) {
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    std::vector<double> sums(rows.dimensions);
    for (const std::uint32_t member : cells[i].members) {
      palette.label[member] = i;
      for (std::size_t d = 0; d < rows.dimensions; ++d)
        sums[d] += static_cast<double>(rows[member][d]);
    }
    for (const double sum : sums)
      palette.values.push_back(
          static_cast<float>(sum / static_cast<double>(cells[i].members.size())));
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
  const std::size_t step = (values.size() + kMostSampled - 1) / kMostSampled;
  const auto [least, largest] = std::ranges::minmax_element(values);
  Array<float> sample = {*least, *largest};
  for (std::size_t i = 0; i < values.size(); i += step) sample.push_back(values[i]);
  Codebook codebook;
  Array<float> entries =
      make_palette({sample.data(), sample.size(), 1, 1}, codebook.values.size(), {}).values;
  std::ranges::sort(entries);
  codebook.values.fill(entries.back());
  std::ranges::copy(entries, codebook.values.begin());
  for (int round = 0; round < kRounds; ++round) {
    std::array<double, 256> sums{}, counts{};
    for (const float value : sample) {
      const std::uint8_t entry = codebook.nearest(value);
      sums[entry] += static_cast<double>(value);
      ++counts[entry];
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
      if (counts[i] > 0) codebook.values[i] = static_cast<float>(sums[i] / counts[i]);
  }
  return codebook;
}

Palette make_palette(const VectorRows& rows, std::size_t most, const Progress& progress) {
  Palette palette;
  palette.dimensions = rows.dimensions;
  palette.label.resize(rows.count);
  std::vector<std::uint32_t> members(rows.count);
  std::iota(members.begin(), members.end(), 0u);
  std::priority_queue<Cell> open;
  open.push(measured(rows, members));
  std::vector<Cell> done;  // cannot be divided
  while (!open.empty() && done.size() + open.size() < most) {
    progress.update(static_cast<float>(done.size() + open.size()) / static_cast<float>(most));
    const Cell cell = open.top();
    open.pop();
    const auto above =
        std::partition(cell.members.begin(), cell.members.end(),
                       [&](std::uint32_t member) { return rows[member][cell.axis] <= cell.mean; });
    if (above == cell.members.begin() || above == cell.members.end()) {
      done.push_back(cell);
    } else {
      open.push(measured(rows, {cell.members.begin(), above}));
      open.push(measured(rows, {above, cell.members.end()}));
    }
  }
  for (; !open.empty(); open.pop()) done.push_back(open.top());
  finish(rows, done, palette);
  return palette;
}

}  // namespace qs
