// SPDX-License-Identifier: MIT
//
// Image quality as a table, as CSV with one row per view and mode, and as JSON with everything
// needed to repeat the evaluation. Of photographs:
//   {"environment": {...}, "scene": {...}, "method": {...}, "view_count": 13, "means": [...],
//    "views": [...]}
// Columns and entries of LPIPS, and of photographs in their lens, exist only if they were computed.
// Means are over the views. Of pictures of many views and the true pictures, the worst view first:
//   {"truth": "plush.spz", "judged": "plush.splat", "environment": {...}, "method": {...},
//    "mean": {...}, "views": [{"view": "7", "psnr": 41.2, "ssim": 0.99, "flip": 0.01, ...}, ...]}
// The PSNR of equal pictures is "inf", null in JSON.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/inspect/picture_pair.h"
#include "raster/kernel/cull/mode.h"
#include "raster/scene/camera.h"
#include "raster/scene/image_metrics.h"

namespace qs {

/// LPIPS of a view, or its mean over views.
struct LpipsValues {
  double paper = 0;      ///< the network's input is 0..1, as in the published scripts of 3DGS
  double symmetric = 0;  ///< the network's input is -1..1, as the authors of LPIPS meant it
};

/// A photograph in its own lens, or the mean over photographs.
struct LensQuality {
  double psnr = 0, ssim = 0;  ///< over the pixels that the lens shows
  double shown = 0;           ///< their share, 0..1
};

/// One view in one mode.
struct EvaluatedView {
  Camera camera;
  std::filesystem::path photograph;
  int width = 0, height = 0;  ///< size of the compared pictures
  CullMode mode = default_mode();
  double psnr = 0, ssim = 0;  ///< dB; 1 for equal pictures
  std::uint64_t view = 0;     ///< number of the view, the same in every shard
  std::optional<LpipsValues> lpips = {};
  /// Of the photograph, in the row of its first face. Unset without a lens, and unless it was asked
  /// for.
  std::optional<LensQuality> in_lens = {};
};

struct EvalReport {
  nlohmann::ordered_json environment, scene;  ///< environment_json() and scene_json()
  nlohmann::ordered_json method;              ///< the choice of views and the method of comparison
  std::size_t view_count = 0;                 ///< number of views in all shards
  std::vector<EvaluatedView> rows;            ///< ordered by view, then by mode
};

/// Means over the views of one mode.
struct MeanQuality {
  CullMode mode = default_mode();
  std::size_t views = 0;
  double psnr = 0, ssim = 0;
  std::optional<LpipsValues> lpips = {};  ///< the mean; set if all of these views have LPIPS
  std::size_t photographs = 0;            ///< that have in_lens
  std::optional<LensQuality> in_lens = {};
};

/// Describes the computation of SSIM, for the method of a report.
std::string ssim_method(SsimBorder border);

/// One entry per mode, in the order of their first rows.
std::vector<MeanQuality> mean_qualities(const std::vector<EvaluatedView>& rows);

std::string format_eval_table(const EvalReport& report);
std::string format_eval_csv(const EvalReport& report);
std::string format_eval_json(const EvalReport& report);

/// Parses the result of format_eval_json(). Throws json::exception and Error.
EvalReport parse_eval_report(const nlohmann::ordered_json& json);

/// Writes eval.csv and eval.json; creates the folder if needed.
void write_eval_report(const EvalReport& report, const std::filesystem::path& folder);

struct Judgement {
  std::string truth, judged;                   ///< the names of the two sides
  nlohmann::ordered_json environment, method;  ///< null without a scene; the method of comparison
  std::vector<PictureQuality> views;
};

/// Sorts the views by PSNR, the worst first; views with equal PSNR by name.
void sort_worst_first(std::vector<PictureQuality>& views);

std::string format_judgement_table(const Judgement& judgement);
std::string format_judgement_csv(const Judgement& judgement);
std::string format_judgement_json(const Judgement& judgement);

/// Writes judge.csv and judge.json to an existing folder.
void write_judgement(const Judgement& judgement, const std::filesystem::path& folder);

}  // namespace qs
