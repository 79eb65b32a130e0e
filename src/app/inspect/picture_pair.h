// SPDX-License-Identifier: MIT
//
// The quality of a picture compared with the true picture of the same view: PSNR, SSIM, FLIP. A
// contact sheet has a row per view: the true picture, the judged one and their visible difference
// (FLIP). One colour bar holds for all rows.
#pragma once

#include <span>
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

/// A row of the sheet: a PicturePair in small, so that many fit into memory.
struct SheetRow {
  PictureQuality quality;
  Image truth, judged;  ///< RGB
  Image flip;           ///< one channel; a pixel is the mean of the pixels that it covers
};

/// The pair at most `width` pixels wide.
SheetRow sheet_row(const PicturePair& pair, int width, ThreadPool& pool);

/// The end of the colour bar: the least of 0.05, 0.1, 0.2, 0.5 and 1 that at least 99.5 % of the
/// drawn errors do not exceed.
double flip_scale(std::span<const SheetRow> rows);

/// `truth` and `judged` name the two sides. At least one row. `scale`: the error at the end of the
/// colour bar, 0 to 1.
Image draw_contact_sheet(std::span<const SheetRow> rows, const std::string& truth,
                         const std::string& judged, double scale);

}  // namespace qs
