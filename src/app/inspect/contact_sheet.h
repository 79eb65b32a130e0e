// SPDX-License-Identifier: MIT
//
// A page with a row per view: the true picture, the judged one and their visible difference (FLIP).
// One colour bar holds for all rows.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/inspect/picture_pair.h"
#include "base/parallel.h"

namespace qs {

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
