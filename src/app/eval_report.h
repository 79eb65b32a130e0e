// SPDX-License-Identifier: MIT
//
// Image quality as people and programs read it: a table, CSV with one row per view and mode, and
// JSON with everything needed to judge or repeat it:
//   {"environment": {...}, "scene": {...}, "method": {...}, "means": [...], "views": [...]}
// Means are those of the views' values. Equal pictures are "inf" dB, null in JSON.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/frame_options.h"

namespace qs {

/// One view in one mode.
struct Quality {
  Camera camera;
  std::filesystem::path photograph;
  int width = 0, height = 0;  ///< at which they were compared
  CullMode mode = kDefaultMode;
  double psnr = 0, ssim = 0;  ///< dB, 1 = equal
};

struct EvalReport {
  std::filesystem::path cameras, images;
  int holdout = 0;            ///< every n-th view, 0 = all
  int images_scale = 1;       ///< divisor of the photographs' size
  std::size_t skipped = 0;    ///< views without a photograph
  std::vector<Quality> rows;  ///< by view, within it by mode
};

/// Mean psnr and ssim of a mode.
Quality mean_quality(const EvalReport& report, CullMode mode);

std::string format_eval_table(const EvalReport& report, const std::vector<CullMode>& modes);
std::string format_eval_csv(const EvalReport& report, const Session& session);
std::string format_eval_json(const EvalReport& report, const Session& session,
                             const std::vector<CullMode>& modes);

}  // namespace qs
