// SPDX-License-Identifier: MIT
#include "app/inspect/picture_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "app/picture/canvas.h"
#include "app/picture/palette.h"
#include "base/rank.h"
#include "base/text.h"
#include "raster/scene/image_metrics.h"

namespace qs {
PicturePair judge_pictures(std::string view, Image truth, Image judged, ThreadPool& pool) {
  clamp_to_unit(truth);
  clamp_to_unit(judged);
  PicturePair pair;
  pair.flip = flip_map(truth, judged, pool);
  pair.quality = {
      std::move(view),           truth.width,         truth.height, psnr(truth, judged, pool),
      ssim(truth, judged, pool), mean_flip(pair.flip)};
  pair.truth = std::move(truth);
  pair.judged = std::move(judged);
  return pair;
}

PictureQuality mean_quality(const std::vector<PictureQuality>& views) {
  PictureQuality mean;
  mean.view = fmt::format("mean of {}", views.size());
  std::size_t different = 0;
  for (const PictureQuality& view : views) {
    if (std::isfinite(view.psnr)) {
      mean.psnr += view.psnr;
      ++different;
    }
    mean.ssim += view.ssim;
    mean.flip += view.flip;
  }
  const auto count = static_cast<double>(views.size());
  mean.psnr = different > 0 ? mean.psnr / static_cast<double>(different)
                            : std::numeric_limits<double>::infinity();
  mean.ssim /= count;
  mean.flip /= count;
  return mean;
}

SheetRow sheet_row(const PicturePair& pair, int width, ThreadPool& pool) {
  const auto small = [&](const Image& image) {
    if (image.width <= width) return image;
    return area_average(image, width, std::max(1, image.height * width / image.width), pool);
  };
  return {pair.quality, small(pair.truth), small(pair.judged), small(pair.flip)};
}

double flip_scale(std::span<const SheetRow> rows) {
  std::vector<float> errors;
  for (const SheetRow& row : rows)
    errors.insert(errors.end(), row.flip.values.begin(), row.flip.values.end());
  if (errors.empty()) return 1;
  const auto most = static_cast<double>(
      at_rank(errors, static_cast<std::size_t>(0.995 * static_cast<double>(errors.size() - 1))));
  for (const double scale : {0.05, 0.1, 0.2, 0.5})
    if (most <= scale) return scale;
  return 1;
}

Image draw_contact_sheet(std::span<const SheetRow> rows, const std::string& truth,
                         const std::string& judged, double scale) {
  constexpr int kMargin = 36, kGap = 14, kBarHeight = 18;
  const Font head(26), text(20);
  const auto row_height = [&](const SheetRow& row) {
    return row.truth.height + text.line_height() + 6 + kGap;
  };
  const int bar_top = kMargin + head.line_height() + 10, bar_bottom = bar_top + kBarHeight + 4;
  int width = 280;  // the headlines fit
  int top = bar_bottom + text.line_height() + 20, height = top + kMargin;
  for (const SheetRow& row : rows) {
    width = std::max(width, row.truth.width);
    height += row_height(row);
  }
  Image page = plain_picture(2 * kMargin + 3 * width + 2 * kGap, height, on_white::kWhite);
  const auto left = [&](int column) { return kMargin + column * (width + kGap); };
  const std::string heads[] = {truth, judged, "visible difference (FLIP)"};
  for (int column = 0; column < 3; ++column)
    draw_text(page, head, {left(column), kMargin}, heads[column], on_white::kInk);
  const auto color_of = [&](float error) { return viridis(error / static_cast<float>(scale)); };
  // The colour bar.
  const int bar = std::min(360, width);
  for (int x = 0; x < bar; ++x)
    fill_rect(page, {left(2) + x, bar_top, 1, kBarHeight},
              viridis(static_cast<float>(x) / static_cast<float>(bar - 1)));
  draw_text(page, text, {left(2), bar_bottom}, "0", on_white::kFaint);
  draw_text(page, text, {left(2) + bar, bar_bottom}, fmt::format("{:g}", scale), on_white::kFaint,
            Align::right);
  for (const SheetRow& row : rows) {
    paste(page, row.truth, {left(0), top});
    paste(page, row.judged, {left(1), top});
    paste(page,
          picture_of(row.flip.width, row.flip.height,
                     [&](int x, int y, int c) { return color_of(row.flip.at(x, y, 0))[c]; }),
          {left(2), top});
    const PictureQuality& q = row.quality;
    const int below = top + row.truth.height + 4;
    draw_text(page, text, {left(0), below}, q.view, on_white::kInk);
    draw_text(page, text, {left(1), below},
              fmt::format("{} dB \u00b7 SSIM {:.4f}", decibels(q.psnr), q.ssim), on_white::kFaint);
    draw_text(page, text, {left(2), below}, fmt::format("FLIP {:.4f}", q.flip), on_white::kFaint);
    top += row_height(row);
  }
  return page;
}

}  // namespace qs
