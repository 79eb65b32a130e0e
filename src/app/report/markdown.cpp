// SPDX-License-Identifier: MIT
#include "app/report/markdown.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "app/measure/statistics.h"
#include "app/report/environment.h"
#include "base/list_of.h"
#include "base/text.h"
#include "raster/api/renderer.h"

namespace qs {
namespace {

// The mean of a column, unset if a row lacks it.
std::optional<double> mean_of_column(const std::vector<const BenchRow*>& rows,
                                     std::optional<double> BenchRow::*column) {
  double sum = 0;
  for (const BenchRow* row : rows) {
    if (!(row->*column)) return std::nullopt;
    sum += *(row->*column);
  }
  return sum / static_cast<double>(rows.size());
}

// The sum of equally weighted values, a member or a function of the rows; unset if a row lacks its
// value.
template <class Row, class ValueOf>
std::optional<double> weighted_mean(const std::vector<const Row*>& rows, const ValueOf& value_of) {
  const double weight = 1.0 / static_cast<double>(rows.size());
  double sum = 0;
  for (const Row* row : rows) {
    const auto value = std::invoke(value_of, *row);
    if (!value) return std::nullopt;
    sum += weight * static_cast<double>(*value);
  }
  return sum;
}

ModeMean mean_of(const std::vector<const BenchRow*>& rows) {
  ModeMean mean;
  const BenchRow& first = *rows.front();
  mean.scene = first.scene;
  mean.mode = mean.label = first.mode;
  mean.pipeline = first.pipeline;
  mean.plugin = first.backend == kPluginBackend;
  mean.rounds = rounds_of(first).size();
  mean.repeats = true;
  const double weight = 1.0 / static_cast<double>(rows.size());
  double mean_noise = 0;
  for (const BenchRow* row : rows) {
    const std::vector<double> rounds = rounds_of(*row);
    const auto [fastest, slowest] = std::ranges::minmax_element(rounds);
    mean.rounds = std::min(mean.rounds, rounds.size());
    mean.ms_fastest += weight * *fastest;
    mean.ms_slowest += weight * *slowest;
    mean.gaussians += weight * row->gaussians;
    mean.pairs += weight * static_cast<double>(row->pairs);
    mean.ms += weight * row->ms_median;
    const double stages[] = {row->preprocess_ms, row->bin_ms, row->sort_ms, row->blend_ms};
    for (int stage = 0; stage < 4; ++stage) mean.stage_ms[stage] += weight * stages[stage];
    mean_noise += weight * noise(*row);
    if (!row->repeats) mean.repeats.reset();
    if (mean.repeats) mean.repeats = *mean.repeats && *row->repeats;
  }
  mean.sort_bytes = weighted_mean(rows, &BenchRow::sort_bytes);
  mean.ms_spread = weighted_mean(rows, spread_ms);
  mean.noisy = mean_noise > kNoiseTolerance || is_noisy_spread(mean.ms_spread, mean.ms);
  mean.enough_frames = are_enough_frames(all_frames(rows));
  mean.psnr = mean_of_column(rows, &BenchRow::psnr_vs_reference);
  mean.ssim = mean_of_column(rows, &BenchRow::ssim_vs_reference);
  mean.flip = mean_of_column(rows, &BenchRow::flip_vs_reference);
  if (const auto ms = mean_of_column(rows, &BenchRow::ms_paper); ms && *ms > 0)
    mean.fps_paper = 1000 / *ms;
  return mean;
}

bool has_paper_fps(const std::vector<ModeMean>& means) {
  return std::ranges::any_of(means,
                             [](const ModeMean& mean) { return mean.fps_paper.has_value(); });
}

std::string table(const std::vector<ModeMean>& means, const std::string& baseline) {
  const bool paper = has_paper_fps(means);
  std::string text = fmt::format(
      "| mode | Gaussians | PSNR dB | ms | FPS |{} vs {} | pairs | sort bytes |\n"
      "|---|---:|---:|---:|---:|{}---:|---:|---:|\n",
      paper ? " FPS (paper) |" : "", baseline, paper ? "---:|" : "");
  for (const ModeMean& mean : means) {
    const auto pairs = static_cast<std::uint64_t>(std::llround(mean.pairs));
    text += fmt::format(
        "| {} | {} | {} | {}{} | {} |{} {} | {} | {} |\n", markdown_code(mean.label),
        grouped(static_cast<std::uint64_t>(std::llround(mean.gaussians))),
        mean.psnr ? decibels(*mean.psnr) : "-", time_text(mean.ms, mean.ms_spread),
        mean.noisy ? " noisy" : "", rate_text(mean.ms, mean.ms_spread),
        !paper           ? ""
        : mean.fps_paper ? fmt::format(" {:.1f} |", *mean.fps_paper)
                         : " - |",
        mean.ratio ? ratio_text(*mean.ratio) : "-",
        mean.plugin && pairs == 0 ? "-" : grouped(pairs),
        mean.sort_bytes ? bytes_text(static_cast<std::uint64_t>(*mean.sort_bytes)) : "-");
  }
  return text;
}

// Empty unless a row was compared with the reference.
std::string quality_table(const std::vector<ModeMean>& means) {
  std::string lines;
  for (const ModeMean& mean : means) {
    if (!mean.psnr || !mean.ssim || !mean.flip) continue;
    lines += fmt::format("| {} | {} | {:.5f} | {:.5f} | {} |\n", markdown_code(mean.label),
                         decibels(*mean.psnr), *mean.ssim, *mean.flip,
                         mean.repeats.value_or(false) ? "yes" : "no");
  }
  if (lines.empty()) return "";
  return fmt::format(
      "\n### {}: image quality against mode reference\n\n| mode | PSNR dB | SSIM | FLIP | two "
      "frames equal |\n|---|---:|---:|---:|---|\n{}",
      markdown_text(means.front().scene), lines);
}

// One column per mode, one row per camera.
std::string camera_table(const std::vector<PairedRatio>& ratios, const std::string& scene,
                         const std::string& baseline) {
  std::vector<std::string> cameras, modes;
  std::map<std::pair<std::string, std::string>, std::string> cells;  // keys: camera, mode
  const bool several = std::ranges::any_of(
      ratios, [&](const PairedRatio& each) { return each.pipeline != ratios.front().pipeline; });
  for (const PairedRatio& each : ratios) {
    if (each.scene != scene || each.camera.empty()) continue;
    const std::string mode = several ? fmt::format("{}, {}", each.mode, each.pipeline) : each.mode;
    add_new(cameras, each.camera);
    add_new(modes, markdown_code(mode));
    cells[{each.camera, markdown_code(mode)}] = ratio_text(each.ratio);
  }
  if (modes.empty()) return "";
  std::string text = fmt::format("\n### {}: ratios to `{}` per camera\n\n| camera | {} |\n|---|",
                                 markdown_text(scene), baseline, joined(modes, " | "));
  for (std::size_t i = 0; i < modes.size(); ++i) text += "---:|";
  for (const std::string& camera : cameras) {
    text += fmt::format("\n| {} |", markdown_text(camera));
    for (const std::string& mode : modes) {
      const auto cell = cells.find({camera, mode});
      text += fmt::format(" {} |", cell == cells.end() ? "-" : cell->second);
    }
  }
  return text + "\n";
}

}  // namespace

std::vector<ModeMean> mode_means(const std::vector<BenchRow>& rows, const std::string& baseline) {
  std::vector<std::vector<const BenchRow*>> groups;
  for (const BenchRow& row : rows) {
    const auto group = std::ranges::find_if(groups, [&](const auto& members) {
      const BenchRow& other = *members.front();
      return other.scene == row.scene && other.mode == row.mode && other.pipeline == row.pipeline;
    });
    (group == groups.end() ? groups.emplace_back() : *group).push_back(&row);
  }
  std::vector<ModeMean> means = list_of<ModeMean>(groups, mean_of);
  const bool several = std::ranges::any_of(
      rows, [&](const BenchRow& row) { return row.pipeline != rows.front().pipeline; });
  const std::vector<PairedRatio> ratios = paired_ratios(rows, baseline);
  for (ModeMean& mean : means) {
    if (several) mean.label = fmt::format("{}, {}", mean.mode, mean.pipeline);
    if (mean.mode == baseline && mean.enough_frames) mean.ratio = Ratio();
    for (const PairedRatio& each : ratios)
      if (each.camera.empty() && each.scene == mean.scene && each.mode == mean.mode &&
          each.pipeline == mean.pipeline)
        mean.ratio = each.ratio;
  }
  return means;
}

std::vector<std::string> different(const std::vector<ModeMean>& means,
                                   std::string ModeMean::*member) {
  std::vector<std::string> words;
  for (const ModeMean& mean : means) add_new(words, mean.*member);
  return words;
}

std::vector<ModeMean> over_scenes(const std::vector<ModeMean>& means) {
  std::vector<ModeMean> result;
  for (const std::string& label : different(means, &ModeMean::label)) {
    std::vector<const ModeMean*> rows;
    for (const ModeMean& row : means)
      if (row.label == label) rows.push_back(&row);
    const ModeMean& first = *rows.front();
    ModeMean& mean = result.emplace_back();
    mean.scene = "mean";
    mean.mode = first.mode;
    mean.pipeline = first.pipeline;
    mean.label = label;
    mean.plugin = first.plugin;
    const double weight = 1.0 / static_cast<double>(rows.size());
    std::vector<double> ratios;
    for (const ModeMean* row : rows) {
      mean.gaussians += weight * row->gaussians;
      mean.pairs += weight * row->pairs;
      mean.ms += weight * row->ms;
      mean.noisy = mean.noisy || row->noisy;
      if (row->ratio) ratios.push_back(row->ratio->value);
    }
    mean.psnr = weighted_mean(rows, &ModeMean::psnr);
    mean.fps_paper = weighted_mean(rows, &ModeMean::fps_paper);
    mean.ms_spread = weighted_mean(rows, &ModeMean::ms_spread);
    mean.sort_bytes = weighted_mean(rows, &ModeMean::sort_bytes);
    if (ratios.size() != rows.size()) continue;
    mean.ratio = geometric_mean(ratios);
    mean.ratio->interval.reset();
  }
  return result;
}

std::string format_markdown(const BenchReport& report) {
  const std::string baseline = baseline_of(report);
  const std::vector<ModeMean> means = mode_means(report.rows, baseline);
  const std::vector<PairedRatio> ratios = paired_ratios(report.rows, baseline);
  std::string text = fmt::format(
      "# Benchmark\n\n{}, backend {}, commit {}, {}. Times are medians per camera, averaged over "
      "the cameras, and half of the distance between the quartiles of the frames. Times are noisy "
      "if this exceeds {:.0f} % or if they drifted or differ between rounds by more than {:.0f} %. "
      "Sort bytes are the keys and values that a frame sorts.\n",
      measured_on(report.environment), report.environment.value("backend", "?"),
      report.environment.value("commit", "?"), report.environment.value("utc", "?"),
      100 * kNoisySpread, 100 * kNoiseTolerance);
  if (has_paper_fps(means))
    text +=
        "\nFPS (paper) is computed as in the published script: after 5 views to warm up, every "
        "view is drawn once, and 1000 is divided by the mean time in milliseconds.\n";
  if (!ratios.empty())
    text += fmt::format(
        "\nRatios are the time of `{}` divided by the mode's time on the same camera in the same "
        "round: the geometric mean over the cameras, and half of its 95 % interval. The interval "
        "of one camera is that of its rounds, and of one round that of its frames. A noisy ratio "
        "does not show a faster mode, because its interval contains 1. Fewer than {} frames have "
        "no ratio.\n",
        baseline, kFewestFrames);
  const std::vector<std::string> scenes = different(means, &ModeMean::scene);
  for (const std::string& name : scenes) {
    std::vector<ModeMean> scene;
    for (const ModeMean& mean : means)
      if (mean.scene == name) scene.push_back(mean);
    std::vector<std::string> cameras, sizes;
    for (const BenchRow& row : report.rows) {
      if (row.scene != name) continue;
      add_new(cameras, row.camera);
      add_new(sizes, fmt::format("{} x {}", row.width, row.height));
    }
    const std::string altered = markdown_text(alterations_in(report.rows, name));
    text += fmt::format("\n## {}\n\n{} camera{}, {}{}\n\n{}", markdown_text(name), cameras.size(),
                        cameras.size() == 1 ? "" : "s", joined(sizes, ", "),
                        altered.empty() ? "" : "; altered: " + altered, table(scene, baseline));
    text += quality_table(scene);
    if (report.environment.contains("baseline")) text += camera_table(ratios, name, baseline);
  }
  if (scenes.size() > 1)
    text += fmt::format(
        "\n## Mean of {} scenes\n\nFPS is computed from the mean time{}; the ratio is the "
        "geometric mean over the scenes.\n\n{}",
        scenes.size(),
        means.front().fps_paper ? ", FPS (paper) is the mean of the scenes' FPS (paper)" : "",
        table(over_scenes(means), baseline));
  for (const std::string& line : clock_lines(report.environment))
    text += fmt::format("\n{}.\n", line);
  return text + plugin_markdown(report.environment);
}

}  // namespace qs
