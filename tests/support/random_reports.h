// SPDX-License-Identifier: MIT
//
// Reports with random numbers, all different: a table or plot that shows a wrong number is
// detected.
#pragma once

#include <algorithm>
#include <random>
#include <string>

#include "app/measure/bench_row.h"
#include "app/report/study_page.h"

namespace qs::test {

inline BenchRow random_row(const std::string& scene, const std::string& mode, std::uint64_t view) {
  static std::mt19937 random(7);
  std::uniform_real_distribution<double> any(1, 50);
  BenchRow row;
  row.scene = scene;
  row.mode = mode;
  row.backend = "cpu";
  row.width = 640;
  row.height = 480;
  row.view = view;
  row.camera = std::to_string(view);
  row.pairs = static_cast<std::uint64_t>(1e6 * any(random));
  row.visible = static_cast<std::uint32_t>(1e5 * any(random));
  for (double* value : {&row.ms_median, &row.ms_p05, &row.ms_p95, &row.fps_median, &row.frame_ms,
                        &row.preprocess_ms, &row.bin_ms, &row.sort_ms, &row.blend_ms})
    *value = any(random);
  row.round_ms = {any(random), any(random), any(random)};
  row.sort_bytes = static_cast<std::uint64_t>(1e6 * any(random));
  return row;
}

inline SceneStudy random_study() {
  std::mt19937 random(3);
  std::uniform_int_distribution<std::uint32_t> any(1000, 9'000'000);
  SceneStudy study;
  study.views = 2;
  study.gaussians = any(random);
  study.visible = any(random);
  study.binned.resize(quantities().size());
  for (BinnedPairs& binned : study.binned) {
    for (auto& count : binned.gaussians) count = any(random);
    for (auto& mode : binned.pairs) {
      for (auto& count : mode) count = any(random);
    }
  }
  for (auto& size : study.modes) {
    for (ModeStudy& mode : size) {
      mode.uses = {any(random), any(random), any(random)};
      mode.pairs = any(random);
      for (int i = 0; i < 1001; ++i) mode.loads.push_back(any(random));
      std::sort(mode.loads.begin(), mode.loads.end());
    }
  }
  for (double& ms : study.frame_ms) ms = any(random) / 1e5;
  return study;
}

}  // namespace qs::test
