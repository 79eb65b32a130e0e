// SPDX-License-Identifier: MIT
//
// The quality of a picture compared with the true picture of the same view: PSNR, SSIM, FLIP.
#pragma once

#include <string>
#include <vector>

#include "base/parallel.h"
#include "raster/scene/image.h"

namespace qs {

struct PictureQuality {
  std::string view;
  int width = 0, height = 0;
  double psnr = 0;  ///< dB, infinity if the pictures are equal
  double ssim = 0;  ///< 1 if equal
  double flip = 0;  ///< mean, 0 if equal
};

/// A view's two pictures and their visible difference, all of one size.
struct PicturePair {
  PictureQuality quality;
  Image truth, judged;  ///< RGB, clamped to 0..1
  Image flip;           ///< see flip_map()
};

/// Both pictures have the same size and at least three channels.
PicturePair judge_pictures(std::string view, Image truth, Image judged, ThreadPool& pool);

/// Means over views. PSNR is the mean over the views that differ, infinity if none does.
PictureQuality mean_quality(const std::vector<PictureQuality>& views);

}  // namespace qs
