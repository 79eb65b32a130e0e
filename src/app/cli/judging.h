// SPDX-License-Identifier: MIT
//
// Judges pictures or a scene against the truth, which is a folder of pictures or another scene.
// `judge A B` and `compare A B` run it.
#pragma once

#include <filesystem>
#include <optional>

#include "app/cli/camera_choice.h"

namespace qs {

struct JudgeOptions {
  FrameOptions frame;  ///< `scene` is the truth: a folder of pictures or a scene
  CameraChoice cameras;
  std::filesystem::path judged;  ///< a folder of pictures or a scene
  std::optional<std::filesystem::path> csv, json, out_dir, sheet;
  int sheet_views = 8;  ///< number of worst views on the sheet
  double flip_max = 0;  ///< end of the sheet's colour bar; 0: chosen from the errors
};

/// Declares the options of the result: --csv, --json, --out-dir, --sheet-views, --flip-max.
void declare_judge_options(Options& options, JudgeOptions& judge);

/// Views are the cameras of the first scene, or the pictures that both folders have. Prints a table
/// and writes the files. Throws Error.
void run_judging(const JudgeOptions& options);

}  // namespace qs
