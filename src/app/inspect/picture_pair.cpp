// SPDX-License-Identifier: MIT
#include "app/inspect/picture_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "app/picture/canvas.h"
#include "app/picture/palette.h"
#include "base/text.h"
#include "raster/scene/flip.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

constexpr int kContactMargin = 36, kContactGap = 14, kBarWidth = 360, kBarHeight = 18;

Image colored(const Image& flip, double scale) {
  return picture_of(flip.width, flip.height, [&](int x, int y, int c) {
    return viridis(flip.at(x, y, 0) / static_cast<float>(scale))[c];
  });
}

class ContactSheet {
 public:
  ContactSheet(std::span<const SheetRow> rows, double scale) : rows_(rows), scale_(scale) {
    for (const SheetRow& row : rows) width_ = std::max(width_, row.truth.width);
    int height = header_height();
    for (const SheetRow& row : rows) height += row_height(row);
    page_ = Image(2 * kContactMargin + 3 * width_ + 2 * kContactGap, height + kContactMargin, 3);
    fill_rect(page_, {0, 0, page_.width, page_.height}, on_white::kWhite);
  }

  Image draw(const std::string& truth, const std::string& judged) {
    const std::string heads[] = {truth, judged, "visible difference (FLIP)"};
    for (int column = 0; column < 3; ++column)
      draw_text(page_, head_, {left(column), kContactMargin}, heads[column], on_white::kInk);
    draw_bar({left(2), kContactMargin + head_.line_height() + 10});
    int top = header_height();
    for (const SheetRow& row : rows_) {
      draw_row(row, top);
      top += row_height(row);
    }
    return std::move(page_);
  }

 private:
  int left(int column) const { return kContactMargin + column * (width_ + kContactGap); }
  int header_height() const {
    return kContactMargin + head_.line_height() + 10 + kBarHeight + text_.line_height() + 24;
  }
  int row_height(const SheetRow& row) const {
    return row.truth.height + text_.line_height() + 6 + kContactGap;
  }

  void draw_bar(glm::ivec2 at) {
    const int width = std::min(kBarWidth, width_);
    for (int x = 0; x < width; ++x) {
      fill_rect(page_, {at.x + x, at.y, 1, kBarHeight},
                viridis(static_cast<float>(x) / static_cast<float>(width - 1)));
    }
    const int below = at.y + kBarHeight + 4;
    draw_text(page_, text_, {at.x, below}, "0", on_white::kFaint);
    draw_text(page_, text_, {at.x + width, below}, fmt::format("{:g}", scale_), on_white::kFaint,
              Align::right);
  }

  void draw_row(const SheetRow& row, int top) {
    const Image* const pictures[] = {&row.truth, &row.judged};
    for (int column = 0; column < 2; ++column) paste(page_, *pictures[column], {left(column), top});
    paste(page_, colored(row.flip, scale_), {left(2), top});
    const PictureQuality& q = row.quality;
    const int below = top + row.truth.height + 4;
    draw_text(page_, text_, {left(0), below}, q.view, on_white::kInk);
    draw_text(page_, text_, {left(1), below},
              fmt::format("{} dB \u00b7 SSIM {:.4f}", decibels(q.psnr), q.ssim), on_white::kFaint);
    draw_text(page_, text_, {left(2), below}, fmt::format("FLIP {:.4f}", q.flip), on_white::kFaint);
  }

  std::span<const SheetRow> rows_;
  double scale_;
  Font head_{26}, text_{20};
  int width_ = 280;  // the headlines fit
  Image page_;
};

}  // namespace

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
  const auto most =
      errors.begin() + static_cast<std::ptrdiff_t>(0.995 * static_cast<double>(errors.size() - 1));
  std::nth_element(errors.begin(), most, errors.end());
  for (const double scale : {0.05, 0.1, 0.2, 0.5})
    if (static_cast<double>(*most) <= scale) return scale;
  return 1;
}

Image draw_contact_sheet(std::span<const SheetRow> rows, const std::string& truth,
                         const std::string& judged, double scale) {
  return ContactSheet(rows, scale).draw(truth, judged);
}

}  // namespace qs
