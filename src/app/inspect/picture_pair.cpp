// SPDX-License-Identifier: MIT
#include "app/inspect/picture_pair.h"

#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "raster/scene/flip.h"
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

}  // namespace qs
