// SPDX-License-Identifier: MIT
//
// Image quality as people and programs read it: a table, CSV with one row per view and mode, and
// JSON with everything needed to judge or repeat it:
//   {"environment": {...}, "scene": {...}, "method": {...}, "view_count": 13, "means": [...],
//    "views": [...]}
// Means are those of the views' values. Equal pictures are "inf" dB, null in JSON.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "raster/kernel/cull/modes.h"
#include "raster/scene/camera.h"

namespace qs {

/// One view in one mode.
struct Quality {
  Camera camera;
  std::filesystem::path photograph;
  int width = 0, height = 0;  ///< at which they were compared
  CullMode mode = kDefaultMode;
  double psnr = 0, ssim = 0;  ///< dB, 1 = equal
  std::uint64_t view = 0;     ///< number of the view in the sweep, the same in every shard
};

struct EvalReport {
  nlohmann::ordered_json environment, scene;  ///< of environment_json() and scene_json()
  nlohmann::ordered_json method;              ///< which views, and how they were compared
  std::size_t view_count = 0;                 ///< of the sweep, in all shards
  std::vector<Quality> rows;                  ///< by view, within it by mode
};

/// Mean over the views of one mode.
struct MeanQuality {
  CullMode mode = kDefaultMode;
  std::size_t views = 0;
  double psnr = 0, ssim = 0;
};

/// In the order of the modes' first rows.
std::vector<MeanQuality> mean_qualities(const std::vector<Quality>& rows);

std::string format_eval_table(const EvalReport& report);
std::string format_eval_csv(const EvalReport& report);
std::string format_eval_json(const EvalReport& report);

/// The report that format_eval_json() wrote. Throws json::exception and Error.
EvalReport parse_eval_report(const nlohmann::ordered_json& json);

/// eval.csv and eval.json; makes the folder if needed.
void write_eval_report(const EvalReport& report, const std::filesystem::path& folder);

}  // namespace qs
