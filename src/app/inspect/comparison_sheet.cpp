// SPDX-License-Identifier: MIT
#include "app/inspect/comparison_sheet.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/picture/canvas.h"
#include "app/picture/image_difference.h"
#include "app/picture/palette.h"
#include "base/text.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

/// Summed-area table: entry (x, y) is the sum of all values above and left of that corner.
class SumTable {
 public:
  template <class Value>
  SumTable(int width, int height, const Value& value)
      : stride_(static_cast<std::size_t>(width) + 1),
        sums_(stride_ * (static_cast<std::size_t>(height) + 1)) {
    for (int y = 0; y < height; ++y) {
      double row = 0;
      for (int x = 0; x < width; ++x) {
        row += value(x, y);
        sums_[index(x + 1, y + 1)] = sums_[index(x + 1, y)] + row;
      }
    }
  }

  double of(const PixelBox& box) const {
    return sums_[index(box.x1, box.y1)] - sums_[index(box.x0, box.y1)] -
           sums_[index(box.x1, box.y0)] + sums_[index(box.x0, box.y0)];
  }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x);
  }

  std::size_t stride_;
  std::vector<double> sums_;
};

constexpr int kSheetMargin = 36, kPanelGap = 16, kPanelWidth = 320;

std::string false_positives(const RenderStats& stats) {
  if (!stats.used_pairs || stats.tile_pairs == 0) return "";
  const auto wasted = static_cast<double>(stats.tile_pairs - *stats.used_pairs);
  return fmt::format("{:.1f} % false positives",
                     100 * wasted / static_cast<double>(stats.tile_pairs));
}

/// Resizes with nearest-neighbour sampling.
Image scaled(const Image& image, int width, int height) {
  return picture_of(width, height, [&](int x, int y, int c) {
    return image.at(x * image.width / width, y * image.height / height, c);
  });
}

/// The whole view, as large as fits into `room`, with the crop outlined.
Image overview(const ViewComparison& comparison, glm::ivec2 room, ThreadPool& pool) {
  const Image& truth = comparison.truth;
  const float scale = std::min(static_cast<float>(room.x) / static_cast<float>(truth.width),
                               static_cast<float>(room.y) / static_cast<float>(truth.height));
  const auto length = [&](int pixels) {
    return std::max(1, static_cast<int>(std::lround(static_cast<float>(pixels) * scale)));
  };
  Image image = area_average(cropped(truth, {0, 0, truth.width, truth.height}), length(truth.width),
                             length(truth.height), pool);
  const PixelBox& crop = comparison.crop;
  const glm::vec2 low = scale * glm::vec2(crop.x0, crop.y0),
                  high = scale * glm::vec2(crop.x1, crop.y1);
  const glm::vec2 corners[] = {low, {high.x, low.y}, high, {low.x, high.y}};
  stroke(image, corners, true, {kRed, 3});
  return image;
}

struct Sheet {
  const ViewComparison& comparison;
  int amplification;
  Font title{34}, head{25}, text{20};
  int panel_height = 0, top = 0;
  Image page;

  Sheet(const ViewComparison& c, int amplify, const std::string& where)
      : comparison(c), amplification(amplify) {
    const int width = c.crop.x1 - c.crop.x0, height = c.crop.y1 - c.crop.y0;
    panel_height = std::clamp(kPanelWidth * height / std::max(width, 1), 40, 2 * kPanelWidth);
    top = kSheetMargin + title.line_height() + text.line_height() + 20;
    const int columns = 1 + static_cast<int>(c.variants.size());
    const int label_height = head.line_height() + 5 * (text.line_height() + 4) + 14;
    page = Image(2 * kSheetMargin + columns * kPanelWidth + (columns - 1) * kPanelGap,
                 top + 2 * panel_height + kPanelGap + label_height + kSheetMargin, 3);
    fill_rect(page, {0, 0, page.width, page.height}, on_white::kWhite);
    draw_text(page, title, {kSheetMargin, kSheetMargin}, where, on_white::kInk);
    draw_text(
        page, text, {kSheetMargin, kSheetMargin + title.line_height() + 4},
        fmt::format("{} \u00d7 {} pixels from {}, {} \u00b7 below each: its difference from {}, "
                    "amplified {} times",
                    width, height, c.crop.x0, c.crop.y0, c.truth_name, amplify),
        on_white::kFaint);
  }

  int left(int column) const { return kSheetMargin + column * (kPanelWidth + kPanelGap); }

  void label(int column, const std::string& name, std::span<const std::string> lines) {
    const int center = left(column) + kPanelWidth / 2;
    int y = top + 2 * panel_height + kPanelGap + 12;
    draw_text(page, head, {center, y}, name, on_white::kInk, Align::center);
    y += head.line_height() + 4;
    for (const std::string& line : lines) {
      draw_text(page, text, {center, y}, line, on_white::kFaint, Align::center);
      y += text.line_height() + 4;
    }
  }

  void truth_column(ThreadPool& pool) {
    const Image crop = cropped(comparison.truth, rect_of(comparison.crop));
    paste(page, scaled(crop, kPanelWidth, panel_height), {left(0), top});
    const Image view = overview(comparison, {kPanelWidth, panel_height}, pool);
    paste(page, view,
          {left(0) + (kPanelWidth - view.width) / 2,
           top + panel_height + kPanelGap + (panel_height - view.height) / 2});
    const std::string lines[] = {"the others are compared with it"};
    label(0, comparison.truth_name, lines);
  }

  void variant_column(int column, const ViewVariant& variant) {
    const Image crop = cropped(variant.color, rect_of(comparison.crop));
    const Image difference =
        amplified_difference(variant.color, comparison.truth, comparison.crop, amplification);
    paste(page, scaled(crop, kPanelWidth, panel_height), {left(column), top});
    paste(page, scaled(difference, kPanelWidth, panel_height),
          {left(column), top + panel_height + kPanelGap});
    const std::string lines[] = {fmt::format("{} dB", decibels(variant.psnr)),
                                 fmt::format("largest difference {}/255", variant.largest),
                                 variant.stats.tile_pairs > 0
                                     ? fmt::format("{} pairs", grouped(variant.stats.tile_pairs))
                                     : "",
                                 false_positives(variant.stats)};
    label(column, variant.name, lines);
  }
};

}  // namespace

ViewVariant draw_variant(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                         std::string name, const Image& truth, std::stop_token stop) {
  Outputs outputs;
  outputs.used = settings.mode != kReferenceMode;
  const Frame& frame = renderer.render(camera, settings, outputs, HostImage{}, std::move(stop));
  const ImageDifference difference = image_difference(frame.color, truth);
  return {std::move(name), frame.color, frame.stats, difference.psnr, difference.largest, {}};
}

PixelBox most_different_crop(const Image& truth, const std::vector<ViewVariant>& variants,
                             glm::ivec2 size) {
  const int width = std::min(size.x, truth.width), height = std::min(size.y, truth.height);
  constexpr int kStep = 4;  // pixels between candidate positions
  PixelBox best{(truth.width - width) / 2, (truth.height - height) / 2, 0, 0};
  double most = 0;
  for (const ViewVariant& variant : variants) {
    const SumTable squares(truth.width, truth.height, [&](int x, int y) {
      double sum = 0;
      for (int c = 0; c < 3; ++c) {
        const double d = difference_8bit(variant.color, truth, x, y, c);
        sum += d * d;
      }
      return sum;
    });
    for (int y = 0; y + height <= truth.height; y += kStep) {
      for (int x = 0; x + width <= truth.width; x += kStep) {
        const double sum = squares.of({x, y, x + width, y + height});
        if (sum <= most) continue;
        most = sum;
        best = {x, y, 0, 0};
      }
    }
  }
  return {best.x0, best.y0, best.x0 + width, best.y0 + height};
}

glm::ivec2 default_crop_size(int width, int height) {
  return {std::max(width / 5, 16), std::max(height / 5, 16)};
}

Image draw_comparison(const ViewComparison& comparison, int amplification, const std::string& where,
                      ThreadPool& pool) {
  Sheet sheet(comparison, amplification, where);
  sheet.truth_column(pool);
  int column = 0;
  for (const ViewVariant& variant : comparison.variants) sheet.variant_column(++column, variant);
  return std::move(sheet.page);
}

std::string format_comparison(const ViewComparison& comparison) {
  std::string text =
      fmt::format("against {}\n{:28}{:>9}{:>9}{:>12}{:>12}{:>8}\n", comparison.truth_name, "",
                  "PSNR dB", "largest", "pairs", "false pos.", "share");
  for (const ViewVariant& variant : comparison.variants) {
    const RenderStats& stats = variant.stats;
    const std::uint64_t wasted = stats.tile_pairs - stats.used_pairs.value_or(stats.tile_pairs);
    const double share = static_cast<double>(wasted) /
                         static_cast<double>(std::max<std::uint64_t>(stats.tile_pairs, 1));
    text += fmt::format("{:28}{:>9}{:>9}{:>12}{:>12}{:>6.1f} %\n", variant.name,
                        decibels(variant.psnr), fmt::format("{}/255", variant.largest),
                        grouped(stats.tile_pairs), grouped(wasted), 100 * share);
    if (!variant.remark.empty()) text += fmt::format("    {}\n", variant.remark);
  }
  return text;
}

}  // namespace qs
