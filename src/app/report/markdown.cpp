// SPDX-License-Identifier: MIT
#include "app/report/markdown.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/session/text.h"
#include "raster/renderer.h"

namespace qs {
namespace {

// Bytes of the keys and values that a frame sorts. Values are 32-bit indices.
double sort_bytes(const BenchRow& row) {
  const auto pairs = static_cast<double>(row.pairs), visible = static_cast<double>(row.visible);
  const double by_depth = visible * (4 + 4);
  if (row.backend != kBackendNames[static_cast<int>(Backend::cuda)]) return by_depth;
  if (row.pipeline == kPipelineNames[static_cast<int>(Pipeline::classic)])
    return pairs * (8 + 4);  // keys of tile and depth
  const bool narrow = TileGrid::of_image(row.width, row.height).count() <= 1 << 16;
  return by_depth + pairs * ((narrow ? 2 : 4) + 4);  // keys of tile
}

ModeMean mean_of(const std::vector<const BenchRow*>& rows) {
  ModeMean mean;
  mean.scene = rows.front()->scene;
  mean.mode = mean.label = rows.front()->mode;
  mean.pipeline = rows.front()->pipeline;
  const double weight = 1.0 / static_cast<double>(rows.size());
  double psnr = 0;
  bool all_have_psnr = true;
  for (const BenchRow* row : rows) {
    mean.gaussians += weight * row->gaussians;
    mean.pairs += weight * static_cast<double>(row->pairs);
    mean.sort_bytes += weight * sort_bytes(*row);
    mean.ms += weight * row->ms_median;
    mean.ms_p05 += weight * row->ms_p05;
    mean.ms_p95 += weight * row->ms_p95;
    const double stages[] = {row->preprocess_ms, row->bin_ms, row->sort_ms, row->blend_ms};
    for (int stage = 0; stage < 4; ++stage) mean.stage_ms[stage] += weight * stages[stage];
    all_have_psnr = all_have_psnr && row->psnr_vs_reference;
    psnr += weight * row->psnr_vs_reference.value_or(0);
  }
  if (all_have_psnr) mean.psnr = psnr;
  return mean;
}

std::string table(const std::vector<ModeMean>& means) {
  std::string text =
      "| mode | Gaussians | PSNR dB | ms | FPS | vs 3dgs | pairs | sort bytes |\n"
      "|---|---:|---:|---:|---:|---:|---:|---:|\n";
  for (const ModeMean& mean : means) {
    const auto pairs = static_cast<std::uint64_t>(std::llround(mean.pairs));
    text += fmt::format("| `{}` | {} | {} | {:.3f} | {:.1f} | {} | {} | {} |\n", mean.label,
                        grouped(static_cast<std::uint64_t>(std::llround(mean.gaussians))),
                        mean.psnr ? decibels(*mean.psnr) : "-", mean.ms, mean.fps(),
                        mean.speedup ? fmt::format("{:.2f}x", *mean.speedup) : "-", grouped(pairs),
                        bytes_text(static_cast<std::uint64_t>(mean.sort_bytes)));
  }
  return text;
}

// Arithmetic means over the scenes. The speed-up is a geometric mean, which does not depend on the
// mode that it is relative to.
std::vector<ModeMean> over_scenes(const std::vector<ModeMean>& means) {
  std::vector<ModeMean> result;
  for (const ModeMean& first : means) {
    const auto same = [&](const ModeMean& other) { return other.label == first.label; };
    if (std::any_of(result.begin(), result.end(), same)) continue;
    const double weight =
        1.0 / static_cast<double>(std::count_if(means.begin(), means.end(), same));
    ModeMean& mean = result.emplace_back();
    mean.scene = "mean";
    mean.label = first.label;
    double psnr = 0, log_speedup = 0;
    bool all_psnr = true, all_speedup = true;
    for (const ModeMean& row : means) {
      if (!same(row)) continue;
      mean.gaussians += weight * row.gaussians;
      mean.pairs += weight * row.pairs;
      mean.sort_bytes += weight * row.sort_bytes;
      mean.ms += weight * row.ms;
      all_psnr = all_psnr && row.psnr;
      all_speedup = all_speedup && row.speedup;
      psnr += weight * row.psnr.value_or(0);
      log_speedup += weight * std::log(row.speedup.value_or(1));
    }
    if (all_psnr) mean.psnr = psnr;
    if (all_speedup) mean.speedup = std::exp(log_speedup);
  }
  return result;
}

}  // namespace

std::vector<ModeMean> mode_means(const std::vector<BenchRow>& rows) {
  std::vector<std::vector<const BenchRow*>> groups;
  for (const BenchRow& row : rows) {
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& members) {
      const BenchRow& other = *members.front();
      return other.scene == row.scene && other.mode == row.mode && other.pipeline == row.pipeline;
    });
    (group == groups.end() ? groups.emplace_back() : *group).push_back(&row);
  }
  std::vector<ModeMean> means;
  for (const auto& group : groups) means.push_back(mean_of(group));
  const bool several = std::any_of(rows.begin(), rows.end(), [&](const BenchRow& row) {
    return row.pipeline != rows.front().pipeline;
  });
  for (ModeMean& mean : means) {
    if (several) mean.label = fmt::format("{}, {}", mean.mode, mean.pipeline);
    const auto base = std::find_if(means.begin(), means.end(), [&](const ModeMean& other) {
      return other.scene == mean.scene && other.mode == "3dgs" && other.pipeline == mean.pipeline;
    });
    if (base != means.end()) mean.speedup = base->ms / mean.ms;
  }
  return means;
}

std::string format_markdown(const BenchReport& report) {
  const std::vector<ModeMean> means = mode_means(report.rows);
  std::string text = fmt::format(
      "# Benchmark\n\n{}, backend {}, commit {}, {}. Times are medians per camera, averaged over "
      "the cameras. Sort bytes are the keys and values that a frame sorts: CUDA `classic` 12 bytes "
      "per pair; CUDA `fast` 6 per pair (8 beyond 65,536 tiles) and 8 per visible Gaussian; CPU 8 "
      "per visible Gaussian.\n",
      measured_on(report.environment), report.environment.value("backend", "?"),
      report.environment.value("commit", "?"), report.environment.value("utc", "?"));
  std::size_t scenes = 0;
  for (std::size_t begin = 0; begin < means.size(); ++scenes) {
    std::vector<ModeMean> scene;
    for (const ModeMean& mean : means) {
      if (mean.scene == means[begin].scene) scene.push_back(mean);
    }
    std::vector<std::string> cameras, sizes;
    for (const BenchRow& row : report.rows) {
      if (row.scene != scene.front().scene) continue;
      const auto add_new = [](std::vector<std::string>& list, const std::string& word) {
        if (std::find(list.begin(), list.end(), word) == list.end()) list.push_back(word);
      };
      add_new(cameras, row.camera);
      add_new(sizes, fmt::format("{} x {}", row.width, row.height));
    }
    text += fmt::format("\n## {}\n\n{} camera{}, {}\n\n{}", scene.front().scene, cameras.size(),
                        cameras.size() == 1 ? "" : "s", joined(sizes, ", "), table(scene));
    begin += scene.size();
  }
  if (scenes > 1) {
    text += fmt::format(
        "\n## Mean of {} scenes\n\nFPS is computed from the mean time; the speed-up is the "
        "geometric mean over the scenes.\n\n{}",
        scenes, table(over_scenes(means)));
  }
  return text;
}

}  // namespace qs
