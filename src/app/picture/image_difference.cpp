// SPDX-License-Identifier: MIT
#include "app/picture/image_difference.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>

#include "base/fail.h"
#include "io/picture/image_file.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

/// `difference_at(x, y, channel)` is the difference of an 8-bit value.
template <class DifferenceAt>
ImageDifference difference_in(const PixelBox& box, int tolerance, DifferenceAt&& difference_at) {
  ImageDifference result;
  std::uint64_t squares = 0;
  std::array<std::uint64_t, 256> histogram{};  // numbers of pixels by their largest difference
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      int largest = 0;
      for (int c = 0; c < 3; ++c) {
        const int difference = std::abs(difference_at(x, y, c));
        squares += static_cast<std::uint64_t>(difference * difference);
        largest = std::max(largest, difference);
      }
      ++histogram[static_cast<std::size_t>(largest)];
      if (largest > tolerance) {
        ++result.pixels;
        if (!result.first) result.first = {x, y};
      }
      if (largest > result.largest) {
        result.largest = largest;
        result.largest_at = {x, y};
      }
    }
  }
  const double values = 3.0 * (box.x1 - box.x0) * (box.y1 - box.y0);
  if (squares > 0) result.psnr = psnr_of(static_cast<double>(squares) / values, 255);
  const std::uint64_t differing =
      std::accumulate(histogram.begin() + 1, histogram.end(), std::uint64_t{0});
  std::uint64_t larger = 0;  // pixels that differ by `usual` or more
  for (result.usual = result.largest; result.usual > 1; --result.usual) {
    larger += histogram[static_cast<std::size_t>(result.usual)];
    if (larger * 50 > differing) break;
  }
  return result;
}

}  // namespace

ImageDifference image_difference(const Image& a, const Image& b, const std::optional<PixelBox>& box,
                                 int tolerance) {
  return difference_in(box.value_or(box_of(a)), tolerance,
                       [&](int x, int y, int c) { return difference_8bit(a, b, x, y, c); });
}

ImageDifference image_difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b,
                                 int width, const PixelBox& box) {
  return difference_in(box, 0, [&](int x, int y, int c) {
    const auto at = static_cast<std::size_t>(4 * (std::int64_t{y} * width + x) + c);
    return a[at] - b[at];
  });
}

int difference_8bit(const Image& a, const Image& b, int x, int y, int channel) {
  return std::abs(to_8bit(a.at(x, y, channel)) - to_8bit(b.at(x, y, channel)));
}

Image amplified_difference(const Image& a, const Image& b, const PixelBox& box, int amplification) {
  return picture_of(box.x1 - box.x0, box.y1 - box.y0, [&](int x, int y, int c) {
    const int amplified = amplification * difference_8bit(a, b, box.x0 + x, box.y0 + y, c);
    return std::min(1.0f, static_cast<float>(amplified) / 255);
  });
}

int amplification_for(int largest_difference) {
  return std::clamp(255 / std::max(largest_difference, 1), 1, 64);
}

int visible_amplification(const ImageDifference& difference) {
  constexpr int kMost = 128;
  int factor = 1;
  while (factor < kMost && 2 * factor * std::max(difference.usual, 1) <= 255) factor *= 2;
  return factor;
}

PixelBox box_of(const Image& image) { return {0, 0, image.width, image.height}; }

PixelRect rect_of(const PixelBox& box) {
  return {box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0};
}

Image read_reference(const std::filesystem::path& path, int width, int height) {
  Image image = read_image(path);
  if (image.width != width || image.height != height)
    fail("{}: is {} x {} pixels, but the frame is {} x {}", path.string(), image.width,
         image.height, width, height);
  if (image.channels >= 3) return image;
  // The file has gray values, with or without alpha.
  return picture_of(width, height, [&](int x, int y, int) { return image.at(x, y, 0); });
}

std::filesystem::path difference_path(const std::filesystem::path& output) {
  return std::filesystem::path(output).replace_extension("").concat(".difference.png");
}

}  // namespace qs
