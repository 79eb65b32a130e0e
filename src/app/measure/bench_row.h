// SPDX-License-Identifier: MIT
//
// One row of a benchmark: the numbers of one mode on one view of one scene.
// To add a column: a member of BenchRow and its line in for_each_column() or for_each_detail().
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace qs {

/// The backend in the rows of renderers from outside this program.
inline constexpr const char* kPluginBackend = "plugin";

/// Times in milliseconds. The members are named like the columns. A plugin's row has the plugin's
/// name as its mode, and the pipeline of the modes with which it was interleaved; numbers that it
/// does not report are 0.
struct BenchRow {
  std::string scene, camera, mode, pipeline = "classic", backend;
  int width = 0, height = 0;
  std::uint32_t gaussians = 0, visible = 0;
  std::uint64_t pairs = 0;
  double pairs_per_visible = 0;
  std::uint32_t max_tile = 0;
  double ms_median = 0, ms_p05 = 0, ms_p95 = 0, fps_median = 0;
  double frame_ms = 0, preprocess_ms = 0, bin_ms = 0, sort_ms = 0, blend_ms = 0;  ///< marked pass
  std::optional<double> psnr_vs_reference;                                        ///< dB
  std::optional<double> ssim_vs_reference, flip_vs_reference;
  std::optional<std::uint64_t>
      false_positives;                         ///< pairs that no pixel uses, from an untimed frame
  std::optional<double> false_positive_share;  ///< share of the pairs, 0..1

  std::optional<bool> repeats;  ///< two frames are equal to the bit
  /// timed frames behind the times, of all rounds; unset in reports of earlier versions
  std::optional<std::uint64_t> frames;
  /// keys and values that a frame sorts; unset in those reports, and for plugins
  std::optional<std::uint64_t> sort_bytes;

  std::uint64_t view = 0;  ///< number of (scene, camera) in the sweep, the same in every shard
  double ms_mean = 0, drift = 0;
  std::vector<double> round_ms;        ///< median of every round, in order
  std::optional<double> round_spread;  ///< relative_spread() of round_ms; unset for one round
  /// half of the distance between the quartiles of the frame times; unset for one frame
  std::optional<double> ms_spread;
  /// the frame's time in a run over the test views, see paper_times(); its mean over the rounds
  std::optional<double> ms_paper;
  /// every timed frame, in order; unset for several rounds and in reports of earlier versions
  std::optional<std::vector<double>> turn_ms;
};

/// Calls visit(name, member) for the columns of the CSV, in their order.
template <class Row, class Visit>
void for_each_column(Row& row, Visit&& visit) {
  visit("scene", row.scene);
  visit("camera", row.camera);
  visit("mode", row.mode);
  visit("pipeline", row.pipeline);
  visit("backend", row.backend);
  visit("width", row.width);
  visit("height", row.height);
  visit("gaussians", row.gaussians);
  visit("visible", row.visible);
  visit("pairs", row.pairs);
  visit("pairs_per_visible", row.pairs_per_visible);
  visit("max_tile", row.max_tile);
  visit("ms_median", row.ms_median);
  visit("ms_p05", row.ms_p05);
  visit("ms_p95", row.ms_p95);
  visit("fps_median", row.fps_median);
  visit("frame_ms", row.frame_ms);
  visit("preprocess_ms", row.preprocess_ms);
  visit("bin_ms", row.bin_ms);
  visit("sort_ms", row.sort_ms);
  visit("blend_ms", row.blend_ms);
  visit("psnr_vs_reference", row.psnr_vs_reference);
  visit("false_positives", row.false_positives);
  visit("false_positive_share", row.false_positive_share);
  visit("ssim_vs_reference", row.ssim_vs_reference);
  visit("flip_vs_reference", row.flip_vs_reference);
  visit("repeats", row.repeats);
  visit("frames", row.frames);
  visit("sort_bytes", row.sort_bytes);
  visit("ms_paper", row.ms_paper);
}

/// The members that only bench.json contains.
template <class Row, class Visit>
void for_each_detail(Row& row, Visit&& visit) {
  visit("view", row.view);
  visit("ms_mean", row.ms_mean);
  visit("drift", row.drift);
  visit("round_ms", row.round_ms);
  visit("round_spread", row.round_spread);
  visit("ms_spread", row.ms_spread);
  visit("turn_ms", row.turn_ms);
}

}  // namespace qs
