// SPDX-License-Identifier: MIT
#include "raster/scene/image_metrics.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "raster/scene/resample.h"

namespace qs {
namespace {

constexpr std::size_t kMetricRows = 32;  // rows of a chunk

[[maybe_unused]] bool same_shape(const Image& a, const Image& b) {
  return a.width == b.width && a.height == b.height && a.channels == b.channels;
}

// The pixels that a mask (see image_metrics.h) does not exclude.
struct Counted {
  const Image& image;
  std::span<const std::uint8_t> mask;

  bool at(int x, int y) const {
    return mask.empty() ||
           mask[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                static_cast<std::size_t>(x)] != 0;
  }
  // Values of pixels that are at least `margin` pixels from the border.
  double values(int margin) const {
    std::int64_t pixels = 0;
    for (int y = margin; y < image.height - margin; ++y)
      for (int x = margin; x < image.width - margin; ++x) pixels += at(x, y) ? 1 : 0;
    return static_cast<double>(pixels * image.channels);
  }
};

// Sum of row_sum(y) over rows 0 to rows - 1. The order of summing is fixed.
template <class F>
double sum_of_rows(int rows, ThreadPool& pool, F row_sum) {
  std::vector<double> sums(static_cast<std::size_t>(rows));
  pool.for_each(sums.size(), kMetricRows,
                [&](std::size_t y) { sums[y] = row_sum(static_cast<int>(y)); });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

constexpr int kRadius = kSsimRadius;

// The shares of old pixels in the area of new ones.
std::vector<Taps> shares(int from, int to) {
  std::vector<Taps> result(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    // The unit is 1 / to of an old pixel: new pixel i covers [begin, end), an old pixel `to` units.
    const std::int64_t begin = std::int64_t{i} * from, end = begin + from;
    Taps& share = result[static_cast<std::size_t>(i)];
    share.first = static_cast<int>(begin / to);
    for (std::int64_t k = share.first; k * to < end; ++k) {
      const auto covered = std::min(end, (k + 1) * to) - std::max(begin, k * to);
      share.weights.push_back(static_cast<double>(covered) / from);
    }
  }
  return result;
}

}  // namespace

double psnr_of(double mean_squared_error, double peak) {
  if (mean_squared_error == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(peak * peak / mean_squared_error);
}

double psnr_8bit(const Image& a, const Image& b, int channels) {
  assert(a.width == b.width && a.height == b.height);
  assert(a.channels >= channels && b.channels >= channels);
  double squared_sum = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      for (int c = 0; c < channels; ++c) {
        const double difference = to_8bit(a.at(x, y, c)) - to_8bit(b.at(x, y, c));
        squared_sum += difference * difference;
      }
    }
  }
  return psnr_of(squared_sum / (static_cast<double>(a.width) * a.height * channels), 255);
}

double psnr(const Image& a, const Image& b, ThreadPool& pool, std::span<const std::uint8_t> mask) {
  assert(same_shape(a, b));
  const Counted counted{a, mask};
  const int values = a.width * a.channels;
  const double error = sum_of_rows(a.height, pool, [&](int y) {
    double sum = 0;
    for (int i = 0; i < values; ++i) {
      if (!counted.at(i / a.channels, y)) continue;
      const double difference = static_cast<double>(a.row(y)[i]) - static_cast<double>(b.row(y)[i]);
      sum += difference * difference;
    }
    return sum;
  });
  return psnr_of(error / counted.values(0));
}

std::vector<double> block_errors(const Image& a, const Image& b, int side) {
  assert(same_shape(a, b));
  std::vector<double> errors;
  for (int top = 0; top < a.height; top += side) {
    for (int left = 0; left < a.width; left += side) {
      const int right = std::min(left + side, a.width), bottom = std::min(top + side, a.height);
      double sum = 0;
      for (int y = top; y < bottom; ++y)
        for (int i = left * a.channels; i < right * a.channels; ++i) {
          const double difference =
              static_cast<double>(a.row(y)[i]) - static_cast<double>(b.row(y)[i]);
          sum += difference * difference;
        }
      errors.push_back(sum / ((right - left) * (bottom - top) * a.channels));
    }
  }
  return errors;
}

double worst_block_psnr(const Image& a, const Image& b, int side) {
  return psnr_of(std::ranges::max(block_errors(a, b, side)));
}

std::array<double, kSsimSize> ssim_window() {
  constexpr double kSigma = 1.5;
  std::array<double, kSsimSize> window{};
  for (int i = -kSsimRadius; i <= kSsimRadius; ++i)
    window[static_cast<std::size_t>(i + kSsimRadius)] = std::exp(-0.5 * i * i / (kSigma * kSigma));
  const double sum = std::accumulate(window.begin(), window.end(), 0.0);
  for (double& weight : window) weight /= sum;
  return window;
}

double ssim(const Image& a, const Image& b, ThreadPool& pool, SsimBorder border,
            std::span<const std::uint8_t> mask) {
  assert(same_shape(a, b));
  const Counted counted{a, mask};
  const auto window = ssim_window();
  const int width = a.width, height = a.height, channels = a.channels;
  const int margin = border == SsimBorder::crop ? kRadius : 0;  // pixels that do not count
  assert(width > 2 * margin && height > 2 * margin);
  const double sum = sum_of_rows(a.height - 2 * margin, pool, [&](int row_of_sum) {
    const int y = row_of_sum + margin;
    // Sums columns first, with kRadius zeros at both ends, then along the row.
    std::vector<SsimMeans> columns(static_cast<std::size_t>(width + 2 * kRadius));
    double row_sum = 0;
    for (int c = 0; c < channels; ++c) {
      std::ranges::fill(columns, SsimMeans{});
      for (int row = std::max(0, y - kRadius); row <= std::min(height - 1, y + kRadius); ++row) {
        const double weight = window[static_cast<std::size_t>(row - y + kRadius)];
        for (int x = 0; x < width; ++x) {
          if (!counted.at(x, row)) continue;
          const auto va = static_cast<double>(a.at(x, row, c));
          const auto vb = static_cast<double>(b.at(x, row, c));
          columns[static_cast<std::size_t>(x + kRadius)].add(weight, SsimMeans::of(va, vb));
        }
      }
      for (int x = margin; x < width - margin; ++x) {
        if (!counted.at(x, y)) continue;
        SsimMeans means{};
        for (std::size_t k = 0; k < window.size(); ++k)
          means.add(window[k], columns[static_cast<std::size_t>(x) + k]);
        row_sum += means.similarity();
      }
    }
    return row_sum;
  });
  return sum / counted.values(margin);
}

Image area_average(const Image& image, int width, int height, ThreadPool& pool) {
  assert(width > 0 && height > 0 && image.width > 0 && image.height > 0);
  if (width == image.width && height == image.height) return image;
  Image result(width, height, image.channels);
  resample(
      std::span(image.values), image.width, image.channels, shares(image.width, width),
      shares(image.height, height), pool, [](double sum) { return static_cast<float>(sum); },
      result.values.data());
  return result;
}

void clamp_to_unit(Image& image) {
  for (float& value : image.values) value = std::min(std::max(0.0f, value), 1.0f);
}

}  // namespace qs
