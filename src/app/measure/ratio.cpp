// SPDX-License-Identifier: MIT
#include "app/measure/ratio.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "app/measure/number_text.h"

namespace qs {
namespace {

// The probability that |t| <= sqrt(degrees) * tan(angle): Abramowitz and Stegun, 26.7.3 and 26.7.4.
double central_probability(double angle, std::size_t degrees) {
  const double cosine = std::cos(angle);
  const bool odd = degrees % 2 == 1;
  double term = std::sin(angle) * (odd ? cosine : 1), sum = 0;
  for (std::size_t k = odd ? 3 : 2; k <= degrees; k += 2) {
    sum += term;
    term *= cosine * cosine * static_cast<double>(k - 1) / static_cast<double>(k);
  }
  return odd ? 2 / std::numbers::pi * (angle + sum) : sum;
}

}  // namespace

double student_t95(std::size_t degrees) {
  assert(degrees > 0);
  double low = 0, high = std::numbers::pi / 2;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (central_probability(middle, degrees) < 0.95 ? low : high) = middle;
  }
  return std::sqrt(static_cast<double>(degrees)) * std::tan(low);
}

Ratio geometric_mean(std::span<const double> ratios) {
  assert(!ratios.empty());
  const auto count = static_cast<double>(ratios.size());
  double mean = 0, squares = 0;
  for (const double ratio : ratios) mean += std::log(ratio) / count;
  for (const double ratio : ratios) squares += std::pow(std::log(ratio) - mean, 2);
  Ratio result{std::exp(mean), std::nullopt, ratios.size()};
  if (ratios.size() > 1) {
    const double half = student_t95(ratios.size() - 1) * std::sqrt(squares / (count - 1) / count);
    result.interval = {std::exp(mean - half), std::exp(mean + half)};
  }
  return result;
}

double half_interval(const Ratio& ratio) {
  return std::max(ratio.interval->high - ratio.value, ratio.value - ratio.interval->low);
}

bool is_undecided(const Ratio& ratio) {
  return ratio.interval && ratio.interval->low <= 1 && ratio.interval->high >= 1;
}

std::string ratio_text(const Ratio& ratio) {
  if (!ratio.interval) return fmt::format("{:.2f}x", ratio.value);
  const double half = half_interval(ratio);
  return fmt::format("{}x \u00b1{}{}", significant(ratio.value, half), significant(half, half),
                     is_undecided(ratio) ? " noisy" : "");
}

}  // namespace qs
