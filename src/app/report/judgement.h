// SPDX-License-Identifier: MIT
//
// Pictures of many views compared with the true pictures, as a table, as CSV with a row per view,
// and as JSON:
//   {"truth": "plush.spz", "judged": "plush.splat", "environment": {...}, "method": {...},
//    "mean": {...}, "views": [{"view": "7", "psnr": 41.2, "ssim": 0.99, "flip": 0.01, ...}, ...]}
// The worst view comes first. The PSNR of equal pictures is "inf", null in JSON.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/inspect/picture_pair.h"

namespace qs {

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
