// SPDX-License-Identifier: MIT
#include "app/inspect/frame_difference.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace qs {

PixelDifference pixel_difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b,
                                 int width, const PixelBox& box) {
  PixelDifference result;
  std::uint64_t squares = 0;
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      const auto at = 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(x));
      int most = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const int difference = std::abs(a[at + c] - b[at + c]);
        squares += static_cast<std::uint64_t>(difference * difference);
        most = std::max(most, difference);
      }
      result.pixels += most > 0;
      if (most <= result.largest) continue;
      result.largest = most;
      result.farthest = {x, y};
    }
  }
  if (squares > 0) {
    const double values = 3.0 * (box.x1 - box.x0) * (box.y1 - box.y0);
    result.psnr = 10 * std::log10(255.0 * 255.0 * values / static_cast<double>(squares));
  }
  return result;
}

PairDifference pair_difference(const TileGrid& grid, std::span<const std::uint32_t> a,
                               std::span<const std::uint32_t> b) {
  PairDifference result{grid, std::vector<std::int32_t>(a.size()), 0};
  for (std::size_t tile = 0; tile < a.size(); ++tile)
    result.values[tile] = static_cast<std::int32_t>(static_cast<std::int64_t>(a[tile]) - b[tile]);
  result.total = std::accumulate(result.values.begin(), result.values.end(), std::int64_t{0});
  return result;
}

}  // namespace qs
