// SPDX-License-Identifier: MIT
//
// bench --lod: the pictures of levels of detail against the picture of all leaves, by distance and
// budget.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "app/cli/camera_choice.h"

namespace qs {

struct LodBench {
  FrameOptions frame;  ///< its scene is the truth; one mode
  CameraChoice cameras;
  /// levels that other tools made; .rad files with a tree, which is cut
  std::vector<std::filesystem::path> others;
  std::vector<double> budgets;  ///< per cent
  int frames = 3, warmup = 1;   ///< per picture
  std::optional<std::filesystem::path> out_dir;
};

inline constexpr const char* kLodFiles[] = {"lod.csv", "lod.md"};

/// Prints the table and writes the files. Throws Error.
void run_lod_bench(const LodBench& bench);

}  // namespace qs
