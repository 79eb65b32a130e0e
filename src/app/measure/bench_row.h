// SPDX-License-Identifier: MIT
//
// One row of a benchmark: the numbers of one mode on one view of one scene.
// To add a column: a member of BenchRow and its entry in kBenchColumns or kBenchDetails.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
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
  /// the alterations of the scene in words, see session/alterations.h; unset without any. A column
  /// and a member only where it is set.
  std::optional<std::string> altered;
  /// the frame's time in a run over the test views, see paper_times(); its mean over the rounds
  std::optional<double> ms_paper;
  /// every timed frame, in order; unset for several rounds and in reports of earlier versions
  std::optional<std::vector<double>> turn_ms;
};

/// The columns of the CSV in their order: names and members.
inline constexpr auto kBenchColumns = std::make_tuple(
    std::pair("scene", &BenchRow::scene), std::pair("camera", &BenchRow::camera),
    std::pair("mode", &BenchRow::mode), std::pair("pipeline", &BenchRow::pipeline),
    std::pair("backend", &BenchRow::backend), std::pair("width", &BenchRow::width),
    std::pair("height", &BenchRow::height), std::pair("gaussians", &BenchRow::gaussians),
    std::pair("visible", &BenchRow::visible), std::pair("pairs", &BenchRow::pairs),
    std::pair("pairs_per_visible", &BenchRow::pairs_per_visible),
    std::pair("max_tile", &BenchRow::max_tile), std::pair("ms_median", &BenchRow::ms_median),
    std::pair("ms_p05", &BenchRow::ms_p05), std::pair("ms_p95", &BenchRow::ms_p95),
    std::pair("fps_median", &BenchRow::fps_median), std::pair("frame_ms", &BenchRow::frame_ms),
    std::pair("preprocess_ms", &BenchRow::preprocess_ms), std::pair("bin_ms", &BenchRow::bin_ms),
    std::pair("sort_ms", &BenchRow::sort_ms), std::pair("blend_ms", &BenchRow::blend_ms),
    std::pair("psnr_vs_reference", &BenchRow::psnr_vs_reference),
    std::pair("false_positives", &BenchRow::false_positives),
    std::pair("false_positive_share", &BenchRow::false_positive_share),
    std::pair("ssim_vs_reference", &BenchRow::ssim_vs_reference),
    std::pair("flip_vs_reference", &BenchRow::flip_vs_reference),
    std::pair("repeats", &BenchRow::repeats), std::pair("frames", &BenchRow::frames),
    std::pair("sort_bytes", &BenchRow::sort_bytes), std::pair("ms_paper", &BenchRow::ms_paper));

/// The members that only bench.json contains.
inline constexpr auto kBenchDetails = std::make_tuple(
    std::pair("view", &BenchRow::view), std::pair("ms_mean", &BenchRow::ms_mean),
    std::pair("drift", &BenchRow::drift), std::pair("round_ms", &BenchRow::round_ms),
    std::pair("round_spread", &BenchRow::round_spread),
    std::pair("ms_spread", &BenchRow::ms_spread), std::pair("turn_ms", &BenchRow::turn_ms));

/// Calls visit(name, member) for the members of a row that a table above lists.
template <class Table, class Row, class Visit>
void for_each_member(const Table& table, Row& row, const Visit& visit) {
  std::apply([&](const auto&... members) { (visit(members.first, row.*members.second), ...); },
             table);
}

}  // namespace qs
