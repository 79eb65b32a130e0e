// SPDX-License-Identifier: MIT
#include "app/measure/noise.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/measure/paired_ratios.h"
#include "app/measure/statistics.h"
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
  for (const BenchRow& row : bad) {
    text += fmt::format("| {} | {} | {} | {:.0f} % | {:+.1f} % | {} |\n", markdown_text(row.scene),
                        markdown_text(row.camera), markdown_code(row.mode), 200 * frame_noise(row),
                        100 * row.drift,
                        row.round_spread ? fmt::format("{:.1f} %", 100 * *row.round_spread)
                                         : "one round has no spread");
  }
  return text;
}

std::string noisy_steps(const std::vector<BenchRow>& rows) {
  constexpr double kCurveTolerance = 0.1;  // a share of the median
  std::vector<std::string> modes, words;
  for (const BenchRow& row : rows) add_new(modes, row.mode);
  int most = 0;
  for (const std::string& mode : modes) {
    int steps = 0, noisy = 0;
    for (const BenchRow& row : rows) {
      if (row.mode != mode) continue;
      ++steps;
      noisy += row.ms_spread && (*row.ms_spread > kCurveTolerance * row.ms_median ||
                                 std::abs(row.drift) > kCurveTolerance);
    }
    most = std::max(most, steps);
    if (noisy > 0) words.push_back(fmt::format("{} {}", mode, noisy));
  }
  return words.empty() ? "" : fmt::format("{} of {}", joined(words, ", "), most);
}

}  // namespace qs
