// SPDX-License-Identifier: MIT
#include "app/viewer/state/mode_numbers.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "app/measure/statistics.h"

namespace qs {
namespace {

bool has_small_interval(const Ratio& ratio) {
  return ratio.interval && ratio.interval->low > 0 &&
         ratio.interval->high - ratio.interval->low <= 2 * kSmallInterval * ratio.value;
}

double measuring_ms(const ModeNumbers& numbers) {
  double sum = 0;
  for (const BenchRow& row : numbers.rows)
    sum = std::accumulate(row.round_ms.begin(), row.round_ms.end(), sum);
  return sum;
}

}  // namespace

const BenchRow* measured_row(const Viewer& viewer, CullMode mode, Pipeline pipeline) {
  const std::string name = mode_name(mode);
  const bool one = pipelines_of(viewer.backend).size() < 2;
  for (const BenchRow& row : viewer.numbers.rows)
    if (row.mode == name && (one || row.pipeline == kPipelineNames[static_cast<int>(pipeline)]))
      return &row;
  return nullptr;
}

glm::ivec2 measured_size(const Viewer& viewer, std::size_t index) {
  if (index == 0) return viewer.bare_size;
  if (index + 1 < std::size(kMeasuredSizes) || viewer.dataset_camera < 0)
    return kMeasuredSizes[index].pixels;
  const Camera& own = viewer.scene->cameras[static_cast<std::size_t>(viewer.dataset_camera)];
  return {own.width, own.height};
}

Camera measured_camera(const Viewer& viewer) {
  const Camera& camera = viewer.camera;
  const glm::ivec2 size = measured_size(viewer, viewer.measured_size);
  if (size.x <= 0 || size.y <= 0 || size == glm::ivec2(camera.width, camera.height)) return camera;
  return camera.resized(size.x, size.y);
}

bool numbers_are_current(const Viewer& viewer) {
  return viewer.numbers.version == viewer.view_version && !viewer.zoom.running;
}

bool numbers_suffice(const Viewer& viewer) {
  const ModeNumbers& numbers = viewer.numbers;
  if (!numbers_are_current(viewer)) return false;
  const std::size_t frames = frames_behind(numbers);
  if (numbers.complete || numbers.rows.empty() || frames >= kEnoughFrames ||
      measuring_ms(numbers) >= kMostMeasuringMs)
    return true;
  if (frames < kFewestFrames) return false;
  for (const Pipeline pipeline : pipelines_of(viewer.backend)) {
    for (CullMode mode = 1; mode <= culler_count(); ++mode) {
      if (mode == viewer.baseline) continue;
      const auto ratio = ratio_to_baseline(viewer, measured_row(viewer, mode, pipeline), pipeline);
      if (ratio && !has_small_interval(*ratio)) return false;
    }
  }
  return true;
}

void add_frames(BenchRow& row, const BenchRow& added) {
  row.round_ms = rounds_of(row);
  const std::vector<double> more = rounds_of(added);
  row.round_ms.insert(row.round_ms.end(), more.begin(), more.end());
  set_times(row, row.round_ms);
  row.round_spread = relative_spread(row.round_ms);
}

std::size_t frames_behind(const ModeNumbers& numbers) {
  std::size_t fewest = numbers.rows.empty() ? 0 : rounds_of(numbers.rows.front()).size();
  for (const BenchRow& row : numbers.rows) fewest = std::min(fewest, rounds_of(row).size());
  return fewest;
}

std::optional<Ratio> ratio_to_baseline(const Viewer& viewer, const BenchRow* row,
                                       Pipeline pipeline) {
  const BenchRow* base = measured_row(viewer, viewer.baseline, pipeline);
  if (row == nullptr || base == nullptr) return std::nullopt;
  return row == base ? Ratio() : paired_ratio(*base, *row);
}

}  // namespace qs
