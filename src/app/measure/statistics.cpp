// SPDX-License-Identifier: MIT
#include "app/measure/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include "app/measure/paired_ratios.h"
#include "base/text.h"

namespace qs {
namespace {

std::vector<BenchRow> noisy(const std::vector<BenchRow>& rows) {
  std::vector<BenchRow> result;
  std::ranges::copy_if(rows, std::back_inserter(result), is_noisy);
  return result;
}

// The spread of the frames, of the median.
double frame_noise(const BenchRow& row) {
  return row.ms_median > 0 ? spread_ms(row).value_or(0) / row.ms_median : 0;
}

// In units of the tolerances.
double severity(const BenchRow& row) {
  return std::max(noise(row) / kNoiseTolerance, frame_noise(row) / kNoisySpread);
}

std::string noise_cause(const BenchRow& row) {
  const double spread = row.round_spread.value_or(0);
  if (frame_noise(row) / kNoisySpread > noise(row) / kNoiseTolerance)
    return fmt::format(
        "the middle half of its frames spans {:.0f} % of the median, so the machine "
        "was not at rest",
        200 * frame_noise(row));
  if (std::abs(row.drift) >= spread)
    return fmt::format(
        "its later frames took {:+.1f} % of the earlier ones' time, so the clock or "
        "the load changed: warm up or measure longer",
        100 * row.drift);
  return fmt::format(
      "the medians of its rounds differ by {:.1f} %, so the machine was not at rest "
      "or the rounds are too short",
      100 * spread);
}

}  // namespace

double percentile(std::span<const double> values, double fraction) {
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  const double place = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

Summary summarise(std::span<const double> values) {
  if (values.empty()) return {};
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  Summary summary{median(values), percentile(values, 0.05), percentile(values, 0.95),
                  sum / static_cast<double>(values.size())};
  const std::size_t half = values.size() / 2;
  if (half > 0) {
    const double first = median(values.first(half)), second = median(values.last(half));
    if (first > 0) summary.drift = second / first - 1;
  }
  return summary;
}

std::optional<double> rank_correlation(std::span<const double> a, std::span<const double> b) {
  // Twice the distance of each rank from the mean rank.
  const auto ranks = [](std::span<const double> values) {
    std::vector<double> sorted(values.begin(), values.end()), result;
    std::ranges::sort(sorted);
    for (const double value : values) {
      const auto [first, last] = std::ranges::equal_range(sorted, value);
      result.push_back(static_cast<double>((first - sorted.begin()) - (sorted.end() - last)));
    }
    return result;
  };
  const std::vector<double> x = ranks(a), y = ranks(b);
  const auto product = [](const std::vector<double>& v, const std::vector<double>& w) {
    return std::inner_product(v.begin(), v.end(), w.begin(), 0.0);
  };
  const double squares = product(x, x) * product(y, y);
  return squares > 0 ? std::optional(product(x, y) / std::sqrt(squares)) : std::nullopt;
}

std::optional<double> quartile_spread(std::span<const double> values) {
  if (values.size() < 2) return std::nullopt;
  return (percentile(values, 0.75) - percentile(values, 0.25)) / 2;
}

void set_times(BenchRow& row, std::span<const double> frame_ms) {
  const Summary summary = summarise(frame_ms);
  row.ms_median = summary.median;
  row.ms_p05 = summary.p05;
  row.ms_p95 = summary.p95;
  row.fps_median = summary.median > 0 ? 1000 / summary.median : 0;
  row.ms_mean = summary.mean;
  row.drift = summary.drift;
  row.frames = frame_ms.size();
  row.ms_spread = quartile_spread(frame_ms);
}

double relative_spread(std::span<const double> values) {
  if (values.size() < 2) return 0;
  const auto [low, high] = std::ranges::minmax_element(values);
  const double middle = median(values);
  return middle > 0 ? (*high - *low) / middle : 0;
}

std::string significant(double value, double uncertainty) {
  constexpr int kMostDecimals = 3;
  if (uncertainty <= 0) return fmt::format("{:.{}f}", value, kMostDecimals);
  const int decimals =
      std::min(kMostDecimals, -static_cast<int>(std::floor(std::log10(uncertainty))));
  if (decimals >= 0) return fmt::format("{:.{}f}", value, decimals);
  const double unit = std::pow(10.0, -decimals);
  return fmt::format("{:.0f}", std::round(value / unit) * unit);
}

// The value of one step in the second significant digit. `value` > 0.
static double second_digit(double value) {
  return std::pow(10.0, std::floor(std::log10(value)) - 1);
}

double rounded(double value) {
  if (value <= 0) return 0;
  const double unit = second_digit(value);
  return std::round(value / unit) * unit;
}

std::string rough(double value) {
  const double shown = rounded(value);
  return shown > 0 ? significant(shown, second_digit(shown)) : "0";
}

std::string ms_text(double ms) { return fmt::format("{:.3f}", ms); }
std::string fps_text(double fps) { return fmt::format("{:.{}f}", fps, fps < 1000 ? 1 : 0); }

std::string three_digits(double value) {
  const double size = std::abs(value);
  const int decimals = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3;
  return fmt::format("{:.{}f}", value, decimals);
}

std::string time_text(double ms, std::optional<double> spread_ms) {
  if (!spread_ms) return ms_text(ms);
  return fmt::format("{} \u00b1{}", significant(ms, *spread_ms),
                     significant(*spread_ms, *spread_ms));
}

bool times_bin(const BenchRow& row) {
  const bool fast = row.pipeline == kPipelineNames[static_cast<int>(Pipeline::fast)];
  const bool cuda = row.backend == kBackendNames[static_cast<int>(Backend::cuda)];
  return is_timed(cuda ? Backend::cuda : Backend::cpu, fast ? Pipeline::fast : Pipeline::classic,
                  Stage::bin);
}

std::string stage_text(const BenchRow& row, Stage stage) {
  if (stage == Stage::bin && !times_bin(row)) return "in preprocess and sort";
  const double ms[kStageCount] = {row.preprocess_ms, row.bin_ms, row.sort_ms, row.blend_ms};
  return ms_text(ms[static_cast<int>(stage)]) + " ms";
}

std::string rate_text(double ms, std::optional<double> spread_ms) {
  const double fps = ms > 0 ? 1000 / ms : 0;
  if (!spread_ms || ms <= 0) return fps_text(fps);
  return significant(fps, std::max(fps * *spread_ms / ms, fps < 1000 ? 0.1 : 1.0));
}

double noise(const BenchRow& row) {
  return std::max(std::abs(row.drift), row.round_spread.value_or(0));
}

std::optional<double> spread_ms(const BenchRow& row) {
  return row.ms_spread ? row.ms_spread : quartile_spread(rounds_of(row));
}

bool has_noisy_time(const BenchRow& row) { return is_noisy_spread(spread_ms(row), row.ms_median); }

bool is_noisy(const BenchRow& row) { return noise(row) > kNoiseTolerance || has_noisy_time(row); }

std::string noise_sentence(const std::vector<BenchRow>& rows) {
  const std::vector<BenchRow> bad = noisy(rows);
  if (bad.empty()) return "";
  const BenchRow& worst = *std::ranges::max_element(bad, {}, severity);
  return fmt::format("{} of {} rows are noisy: the worst is {}, camera {}, {}: {}", bad.size(),
                     rows.size(), worst.scene, worst.camera, worst.mode, noise_cause(worst));
}

std::string noise_markdown(const std::vector<BenchRow>& rows) {
  const std::vector<BenchRow> bad = noisy(rows);
  if (bad.empty()) return "";
  std::string text = fmt::format(
      "\n## Noisy rows\n\nDo not publish these: {}.\n\n| scene | camera | mode | middle half of "
      "the "
      "frames | drift | rounds differ by |\n|---|---|---|---:|---:|---:|\n",
      noise_sentence(rows));
  for (const BenchRow& row : bad)
    text += fmt::format("| {} | {} | {} | {:.0f} % | {:+.1f} % | {} |\n", markdown_text(row.scene),
                        markdown_text(row.camera), markdown_code(row.mode), 200 * frame_noise(row),
                        100 * row.drift,
                        row.round_spread ? fmt::format("{:.1f} %", 100 * *row.round_spread)
                                         : "one round has no spread");
  return text;
}

bool is_noisy_step(const BenchRow& row) {
  constexpr double kCurveTolerance = 0.1;  // a share of the median
  return row.ms_spread && (*row.ms_spread > kCurveTolerance * row.ms_median ||
                           std::abs(row.drift) > kCurveTolerance);
}

std::string noisy_steps(const std::vector<BenchRow>& rows) {
  std::vector<std::string> modes, words;
  for (const BenchRow& row : rows) add_new(modes, row.mode);
  int most = 0;
  for (const std::string& mode : modes) {
    int steps = 0, noisy = 0;
    for (const BenchRow& row : rows) {
      if (row.mode != mode) continue;
      ++steps;
      noisy += is_noisy_step(row);
    }
    most = std::max(most, steps);
    if (noisy > 0) words.push_back(fmt::format("{} {}", mode, noisy));
  }
  return words.empty() ? "" : fmt::format("{} of {}", joined(words, ", "), most);
}

}  // namespace qs
