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
  stroke(image,
         corners_of(scale * glm::vec2(crop.x0, crop.y0), scale * glm::vec2(crop.x1, crop.y1)), true,
         {kRed, 3});
  return image;
}

}  // namespace

std::string drawn_by(const Variant& variant) {
  const char* backend = kBackendNames[static_cast<int>(variant.backend)];
  if (variant.backend == Backend::cpu) return backend;
  return fmt::format("{} {}", backend, kPipelineNames[static_cast<int>(variant.pipeline)]);
}

std::string full_name(const Variant& variant) {
  if (variant.mode == kReferenceMode) return mode_name(variant.mode);
  return fmt::format("{}, {}", mode_name(variant.mode), drawn_by(variant));
}

std::string name_beside(const Variant& variant, const Variant& other) {
  const bool alike = drawn_by(variant) == drawn_by(other) || other.mode == kReferenceMode;
  return alike ? mode_name(variant.mode) : full_name(variant);
}

std::optional<Variant> find_variant(std::string_view name, const Variant& like) {
  if (const CullMode mode = find_culler(name); mode >= 0)
    return Variant{mode, like.pipeline, like.backend};
  for (CullMode mode = 1; mode <= mode_count(); ++mode) {
    for (const Backend backend : available_backends()) {
      for (const Pipeline pipeline : pipelines_of(backend)) {
        const Variant variant{mode, pipeline, backend};
        if (full_name(variant) == name) return variant;
      }
    }
  }
  return std::nullopt;
}

ViewVariant draw_variant(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                         std::string name, const Image& truth, std::stop_token stop) {
  const Frame& frame = renderer.render(camera, settings, {.used = settings.mode != kReferenceMode},
                                       HostImage{}, std::move(stop));
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
  constexpr int kMargin = 36, kGap = 16, kWidth = 320;
  const Font title(34), head(25), text(20);
  const PixelRect crop = rect_of(comparison.crop);
  const int height = std::clamp(kWidth * crop.height / std::max(crop.width, 1), 40, 2 * kWidth);
  const int top = kMargin + title.line_height() + text.line_height() + 20;
  const int second = top + height + kGap;
  const int columns = 1 + static_cast<int>(comparison.variants.size());
  const int label_height = head.line_height() + 5 * (text.line_height() + 4) + 14;
  Image page = plain_picture(2 * kMargin + columns * kWidth + (columns - 1) * kGap,
                             second + height + label_height + kMargin, on_white::kWhite);
  draw_text(page, title, {kMargin, kMargin}, where, on_white::kInk);
  draw_text(
      page, text, {kMargin, kMargin + title.line_height() + 4},
      fmt::format("{} \u00d7 {} pixels from {}, {} \u00b7 below each: its difference from {}, "
                  "amplified {} times",
                  crop.width, crop.height, crop.x, crop.y, comparison.truth_name, amplification),
      on_white::kFaint);
  int left = kMargin;
  const auto add_column = [&](const std::string& name, const Image& whole, const Image& below,
                              const std::vector<std::string>& lines) {
    paste(page, scaled(cropped(whole, crop), kWidth, height), {left, top});
    paste(page, below, {left + (kWidth - below.width) / 2, second + (height - below.height) / 2});
    const int center = left + kWidth / 2;
    int y = second + height + 12;
    draw_text(page, head, {center, y}, name, on_white::kInk, Align::center);
    y += head.line_height() + 4;
    for (const std::string& line : lines) {
      draw_text(page, text, {center, y}, line, on_white::kFaint, Align::center);
      y += text.line_height() + 4;
    }
    left += kWidth + kGap;
  };
  add_column(comparison.truth_name, comparison.truth, overview(comparison, {kWidth, height}, pool),
             {"the others are compared with it"});
  for (const ViewVariant& variant : comparison.variants) {
    const Image difference =
        amplified_difference(variant.color, comparison.truth, comparison.crop, amplification);
    const std::uint64_t pairs = variant.stats.tile_pairs;
    add_column(
        variant.name, variant.color, scaled(difference, kWidth, height),
        {fmt::format("{} dB", decibels(variant.psnr)),
         fmt::format("largest difference {}/255", variant.largest),
         pairs > 0 ? fmt::format("{} pairs", grouped(pairs)) : "", false_positives(variant.stats)});
  }
  return page;
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
